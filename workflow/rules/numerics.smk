# Numerical stability: the paper's formulas and sweep beside ours, docs/numerical_stability.md.

NUMERICS = "results/hard_cases"


rule measure_numerics:
    input:
        f"{NUMERICS}/logs/kernels.txt",
    output:
        numerics=f"{NUMERICS}/tables/numerics.csv",
        loads=f"{NUMERICS}/tables/sweep_loads.csv",
    script:
        "../scripts/measure_numerics.py"


rule draw_numerics:
    input:
        f"{NUMERICS}/tables/numerics.csv",
    output:
        figures=expand(f"{NUMERICS}/figures/numerics.{{format}}", format=["png", "pdf"]),
    params:
        figure="numerics",
    script:
        "../scripts/draw_table.py"

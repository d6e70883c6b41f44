# Numerical stability: the paper's formulas and sweep beside ours, docs/numerical_stability.md.

NUMERICS = "results/hard_cases"


rule measure_numerics:
    input:
        f"{NUMERICS}/logs/kernels.txt",
    output:
        numerics=f"{NUMERICS}/tables/numerics.csv",
        loads=f"{NUMERICS}/tables/sweep_loads.csv",
        seal=f"{NUMERICS}/seals/measure_numerics.json",
    log:
        f"{NUMERICS}/logs/measure_numerics.log",
    benchmark:
        f"{NUMERICS}/benchmarks/measure_numerics.tsv"
    conda:
        ENVIRONMENT
    params:
        code=code_of("measure_numerics"),
    message:
        "Measure the paper's formulas and sweep, and ours, against exact values"
    script:
        "../scripts/measure_numerics.py"


rule draw_numerics:
    input:
        f"{NUMERICS}/tables/numerics.csv",
        seals=seals_of("measure_numerics", study=NUMERICS),
    output:
        figures=expand(f"{NUMERICS}/figures/numerics.{{format}}", format=["png", "pdf"]),
        seal=f"{NUMERICS}/seals/draw_numerics.json",
    log:
        f"{NUMERICS}/logs/draw_numerics.log",
    benchmark:
        f"{NUMERICS}/benchmarks/draw_numerics.tsv"
    conda:
        ENVIRONMENT
    params:
        figure="numerics",
        made_with=HARD_WITH,
        code=code_of("draw_table"),
    message:
        "Draw what the paper's formulas lose, and how its sweep converges"
    script:
        "../scripts/draw_table.py"

# Joints that are hard to solve, judged by an oracle, and tests of the paper's formulas and sweep
# (docs/model.md): `snakemake hard_cases`. No other rule depends on this study.
from studies.verification.hard_cases import kernels_of_cases, merged_cases

HARD_RESULTS = "results/hard_cases"
HARD_CASES = merged_cases(read_plain(ROOTS["studies"] / "verification/hard_cases.yaml"))
HARD_GROUPS = sorted({case["group"] for case in HARD_CASES.values()})
HARD_FIGURES = [
    f"{HARD_RESULTS}/figures/{figure}.{format}"
    for figure in ("hard_cases", "numerics")
    for format in ("png", "pdf")
]


wildcard_constraints:
    hard_group="[a-z][a-z0-9_]*",


rule hard_cases:
    input:
        f"{HARD_RESULTS}/tables/hard_cases.csv",
        f"{HARD_RESULTS}/tables/hard_case_errors.csv",
        f"{HARD_RESULTS}/tables/hard_case_features.csv",
        f"{HARD_RESULTS}/tables/analytic.csv",
        HARD_FIGURES,
    message:
        "The hard cases are closed and judged"


rule compile_hard_cases:
    output:
        f"{HARD_RESULTS}/logs/kernels.txt",
    params:
        kernels=kernels_of_cases(HARD_CASES.values()),
    script:
        "../scripts/compile_kernels.py"


rule close_hard_cases:
    input:
        f"{HARD_RESULTS}/logs/kernels.txt",
    output:
        table=f"{HARD_RESULTS}/cases/{{hard_group}}.csv",
        curves=f"{HARD_RESULTS}/cases/{{hard_group}}.curves.csv",
    params:
        cases=HARD_CASES,
    script:
        "../scripts/close_hard_cases.py"


rule measure_numerics:
    input:
        f"{HARD_RESULTS}/logs/kernels.txt",
    output:
        numerics=f"{HARD_RESULTS}/tables/numerics.csv",
        loads=f"{HARD_RESULTS}/tables/sweep_loads.csv",
        analytic=f"{HARD_RESULTS}/tables/analytic.csv",
    script:
        "../scripts/measure_numerics.py"


rule present_hard_cases:
    input:
        tables=expand(f"{HARD_RESULTS}/cases/{{group}}.csv", group=HARD_GROUPS),
        curves=expand(f"{HARD_RESULTS}/cases/{{group}}.curves.csv", group=HARD_GROUPS),
        formulas=f"{HARD_RESULTS}/tables/numerics.csv",
        loads=f"{HARD_RESULTS}/tables/sweep_loads.csv",
    output:
        table=f"{HARD_RESULTS}/tables/hard_cases.csv",
        errors=f"{HARD_RESULTS}/tables/hard_case_errors.csv",
        features=f"{HARD_RESULTS}/tables/hard_case_features.csv",
        figures=HARD_FIGURES,
    params:
        order=list(HARD_CASES),
    script:
        "../scripts/present_hard_cases.py"

# Joints that are hard on a solver, closed and judged by an oracle, and the paper's formulas and sweep beside ours
# (docs/numerical_stability.md): `snakemake hard_cases`. A study of its own, which no other rule depends on.
from jointclosure.verification.hard_cases import kernels_of_cases, merged_cases

HARD_RESULTS = "results/hard_cases"
HARD_CASES = merged_cases(read_plain(ROOT / "config/hard_cases.yaml"))
HARD_GROUPS = sorted({case["group"] for case in HARD_CASES.values()})
HARD_FIGURES = [
    f"{HARD_RESULTS}/figures/{figure}.{format}"
    for figure in ("hard_cases", "numerics")
    for format in ("png", "pdf")
]


HARD_TOLD = {"cases": HARD_CASES, "code": code_of("close_hard_cases")}
HARD_WITH = {
    seal: settings_digest(HARD_TOLD)
    for seal in seals_of(
        *(f"close_hard_cases/{group}" for group in HARD_GROUPS), study=HARD_RESULTS
    )
} | {
    seals_of("measure_numerics", study=HARD_RESULTS)[0]: settings_digest(
        {"code": code_of("measure_numerics")}
    )
}


wildcard_constraints:
    hard_group="[a-z][a-z0-9_]*",


rule hard_cases:
    input:
        f"{HARD_RESULTS}/tables/hard_cases.csv",
        HARD_FIGURES,
        seals_of("present_hard_cases", study=HARD_RESULTS),
    message:
        "The hard cases are closed and judged"


rule compile_hard_cases:
    output:
        f"{HARD_RESULTS}/logs/kernels.txt",
    log:
        f"{HARD_RESULTS}/logs/compile_hard_cases.log",
    benchmark:
        f"{HARD_RESULTS}/benchmarks/compile_hard_cases.tsv"
    conda:
        ENVIRONMENT
    params:
        kernels=kernels_of_cases(HARD_CASES.values()),
        code=code_of("compile_kernels"),
    message:
        "Compile the kernels of all scenes (two minutes when they are new)"
    script:
        "../scripts/compile_kernels.py"


rule close_hard_cases:
    input:
        f"{HARD_RESULTS}/logs/kernels.txt",
    output:
        table=f"{HARD_RESULTS}/cases/{{hard_group}}.csv",
        curves=f"{HARD_RESULTS}/cases/{{hard_group}}.curves.csv",
        seal=f"{HARD_RESULTS}/seals/close_hard_cases/{{hard_group}}.json",
    log:
        f"{HARD_RESULTS}/logs/close_hard_cases/{{hard_group}}.log",
    benchmark:
        f"{HARD_RESULTS}/benchmarks/close_hard_cases/{{hard_group}}.tsv"
    conda:
        ENVIRONMENT
    params:
        **HARD_TOLD,
    message:
        "Close the hard cases of {wildcards.hard_group}"
    script:
        "../scripts/close_hard_cases.py"


rule measure_numerics:
    input:
        f"{HARD_RESULTS}/logs/kernels.txt",
    output:
        numerics=f"{HARD_RESULTS}/tables/numerics.csv",
        loads=f"{HARD_RESULTS}/tables/sweep_loads.csv",
        seal=f"{HARD_RESULTS}/seals/measure_numerics.json",
    log:
        f"{HARD_RESULTS}/logs/measure_numerics.log",
    benchmark:
        f"{HARD_RESULTS}/benchmarks/measure_numerics.tsv"
    conda:
        ENVIRONMENT
    params:
        code=code_of("measure_numerics"),
    message:
        "Measure the paper's formulas and sweep, and ours, against exact values"
    script:
        "../scripts/measure_numerics.py"


rule present_hard_cases:
    input:
        tables=expand(f"{HARD_RESULTS}/cases/{{group}}.csv", group=HARD_GROUPS),
        curves=expand(f"{HARD_RESULTS}/cases/{{group}}.curves.csv", group=HARD_GROUPS),
        formulas=f"{HARD_RESULTS}/tables/numerics.csv",
        loads=f"{HARD_RESULTS}/tables/sweep_loads.csv",
        seals=list(HARD_WITH),
    output:
        table=f"{HARD_RESULTS}/tables/hard_cases.csv",
        figures=HARD_FIGURES,
        seal=f"{HARD_RESULTS}/seals/present_hard_cases.json",
    log:
        f"{HARD_RESULTS}/logs/present_hard_cases.log",
    benchmark:
        f"{HARD_RESULTS}/benchmarks/present_hard_cases.tsv"
    conda:
        ENVIRONMENT
    params:
        order=list(HARD_CASES),
        made_with=HARD_WITH,
        code=code_of("present_hard_cases"),
    message:
        "Write the table and the pictures of the hard cases"
    script:
        "../scripts/present_hard_cases.py"

# Joints that are difficult for a solver, simulated and judged by an independent oracle. They depend
# on no configuration, and no other rule depends on them.


use rule compile_kernels as compile_hard_cases with:
    output:
        "results/hard_cases/kernels/{scene}.{peaks}.{bound}.{solver}.{breakage}.txt",
    log:
        "results/hard_cases/logs/compile/{scene}.{peaks}.{bound}.{solver}.{breakage}.log",


rule close_hard_cases:
    input:
        kernels=lambda w: hard_case_kernels(),
    output:
        "results/hard_cases/cases/{group}.csv",
    log:
        "results/hard_cases/logs/close_hard_cases/{group}.log",
    conda:
        ENVIRONMENT
    params:
        cases=lambda w: dict(sorted(hard_cases().items())),
        code=code("close_hard_cases.py", titles=False),
    message:
        "Close and judge the hard cases of the group {wildcards.group}"
    script:
        "../scripts/close_hard_cases.py"


rule tabulate_hard_cases:
    input:
        lambda w: collect(
            "results/hard_cases/cases/{group}.csv",
            group=sorted({case["group"] for case in hard_cases().values()}),
        ),
    output:
        cases="results/hard_cases/tables/hard_cases.csv",
        errors="results/hard_cases/tables/hard_case_errors.csv",
        features="results/hard_cases/tables/hard_case_features.csv",
    log:
        "results/hard_cases/logs/tabulate_hard_cases.log",
    conda:
        ENVIRONMENT
    params:
        order=lambda w: list(hard_cases()),
        code=code("tabulate_hard_cases.py"),
    message:
        "Join the groups of hard cases in one table, and tabulate their errors"
    script:
        "../scripts/tabulate_hard_cases.py"


# apart from the table, so that this remains when a case does not hold
rule hard_cases:
    input:
        rules.tabulate_hard_cases.output.cases,
    output:
        "results/hard_cases/logs/all_hold.txt",
    log:
        "results/hard_cases/logs/hard_cases.log",
    conda:
        ENVIRONMENT
    message:
        "Fail if a hard case does not hold"
    script:
        "../scripts/require_hard_cases.py"

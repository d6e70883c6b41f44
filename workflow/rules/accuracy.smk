# What accuracy costs: `snakemake accuracy --configfile config/accuracy.yaml`. Settings are those of
# the configuration's `accuracy` section; without it there are none, and no rule here has work.
from jointclosure.studies.accuracy import design as accuracy

ACCURACY = config.get("accuracy")
ACCURACY_SETTINGS, ACCURACY_RUNS = accuracy.design_of(config) if ACCURACY else ([], {})
ACCURACY_WITH = {
    seals_of(f"close_accuracy/{name}")[0]: settings_digest(
        {"run": to_plain(run), "code": code_of("close_accuracy")}
    )
    for name, run in ACCURACY_RUNS.items()
}
TOTAL = ACCURACY.get("total") if ACCURACY else None
# of the study whose size and stress the variant has: nothing here makes it
TOTAL_TABLES = (
    {
        name: f"results/{TOTAL['study']}/tables/{name}.csv"
        for name in ("variance_reduction", "surrogate")
    }
    if TOTAL
    else {}
)
ACCURACY_FIGURES = sorted({setting.scene for setting in ACCURACY_SETTINGS})


wildcard_constraints:
    run="[a-z0-9_-]+",


rule accuracy:
    input:
        f"{RESULTS}/tables/accuracy_estimate.csv",
        f"{RESULTS}/tables/accuracy_cost.csv",
        f"{RESULTS}/tables/accuracy_orders.csv",
        f"{RESULTS}/tables/accuracy_sources.csv",
        expand(
            f"{RESULTS}/figures/accuracy_{{figure}}.{{format}}",
            figure=[*ACCURACY_FIGURES, "sources"],
            format=["png", "pdf"],
        ),
        seals_of("estimate_accuracy", "weigh_accuracy", "draw_accuracy"),
    message:
        "What accuracy costs is known"


rule compile_accuracy:
    output:
        f"{RESULTS}/logs/accuracy_kernels.txt",
    log:
        f"{RESULTS}/logs/compile_accuracy.log",
    benchmark:
        f"{RESULTS}/benchmarks/compile_accuracy.tsv"
    conda:
        ENVIRONMENT
    params:
        kernels=kernels_of(
            (level.case.effects, level.choices, level.numerics)
            for run in ACCURACY_RUNS.values()
            for level in run.levels
        ),
        code=code_of("compile_kernels"),
    message:
        "Compile the kernels of all settings"
    script:
        "../scripts/compile_kernels.py"


rule estimate_accuracy:
    input:
        f"{RESULTS}/logs/accuracy_kernels.txt",
    output:
        f"{RESULTS}/tables/accuracy_estimate.csv",
        seal=f"{RESULTS}/seals/estimate_accuracy.json",
    log:
        f"{RESULTS}/logs/estimate_accuracy.log",
    benchmark:
        f"{RESULTS}/benchmarks/estimate_accuracy.tsv"
    priority: 100
    conda:
        ENVIRONMENT
    params:
        runs=lambda wildcards: to_plain(ACCURACY_RUNS),
        code=code_of("estimate_accuracy"),
    message:
        "Estimate the core-hours, by one joint at every setting"
    script:
        "../scripts/estimate_accuracy.py"


rule close_accuracy:
    input:
        f"{RESULTS}/logs/accuracy_kernels.txt",
    output:
        f"{RESULTS}/accuracy/{{run}}.nc",
        seal=f"{RESULTS}/seals/close_accuracy/{{run}}.json",
    log:
        f"{RESULTS}/logs/close_accuracy/{{run}}.log",
    benchmark:
        f"{RESULTS}/benchmarks/close_accuracy/{{run}}.tsv"
    conda:
        ENVIRONMENT
    params:
        run=lambda wildcards: to_plain(ACCURACY_RUNS[wildcards.run]),
        code=code_of("close_accuracy"),
    message:
        "Close the surfaces of {wildcards.run}"
    script:
        "../scripts/close_accuracy.py"


rule weigh_accuracy:
    input:
        runs=expand(f"{RESULTS}/accuracy/{{run}}.nc", run=ACCURACY_RUNS),
        seals=list(ACCURACY_WITH),
    output:
        costs=f"{RESULTS}/tables/accuracy_cost.csv",
        orders=f"{RESULTS}/tables/accuracy_orders.csv",
        sources=f"{RESULTS}/tables/accuracy_sources.csv",
        settings=f"{RESULTS}/tables/accuracy_settings.csv",
        seal=f"{RESULTS}/seals/weigh_accuracy.json",
    log:
        f"{RESULTS}/logs/weigh_accuracy.log",
    benchmark:
        f"{RESULTS}/benchmarks/weigh_accuracy.tsv"
    conda:
        ENVIRONMENT
    params:
        settings=lambda wildcards: to_plain(ACCURACY_SETTINGS),
        runs=list(ACCURACY_RUNS),
        design=ACCURACY,
        root_seed=CONFIGURATION.study.root_seed,
        realizations=CONFIGURATION.study.realizations,
        significance=CONFIGURATION.statistics.significance,
        made_with=ACCURACY_WITH,
        code=code_of("weigh_accuracy"),
    message:
        "Weigh error against time"
    script:
        "../scripts/weigh_accuracy.py"


rule draw_accuracy:
    input:
        costs=f"{RESULTS}/tables/accuracy_cost.csv",
        sources=f"{RESULTS}/tables/accuracy_sources.csv",
        seals=seals_of("weigh_accuracy"),
    output:
        figures=expand(
            f"{RESULTS}/figures/accuracy_{{figure}}.{{format}}",
            figure=[*ACCURACY_FIGURES, "sources"],
            format=["png", "pdf"],
        ),
        seal=f"{RESULTS}/seals/draw_accuracy.json",
    log:
        f"{RESULTS}/logs/draw_accuracy.log",
    benchmark:
        f"{RESULTS}/benchmarks/draw_accuracy.tsv"
    conda:
        ENVIRONMENT
    params:
        code=code_of("draw_accuracy"),
    message:
        "Draw error against time"
    script:
        "../scripts/draw_accuracy.py"


rule total_error:
    input:
        f"{RESULTS}/tables/accuracy_total.csv",
        f"{RESULTS}/tables/accuracy_split.csv",
        expand(f"{RESULTS}/figures/accuracy_total.{{format}}", format=["png", "pdf"]),
        seals_of("weigh_total_error"),
    message:
        "The total error of every way to a result is known"


rule weigh_total_error:
    input:
        costs=f"{RESULTS}/tables/accuracy_cost.csv",
        variance=TOTAL_TABLES.get("variance_reduction", []),
        surrogate=TOTAL_TABLES.get("surrogate", []),
        seals=seals_of("weigh_accuracy")
        + (
            seals_of(
                "reduce_variance",
                "calibrate_surrogate",
                study=f"results/{TOTAL['study']}",
            )
            if TOTAL
            else []
        ),
    output:
        methods=f"{RESULTS}/tables/accuracy_methods.csv",
        points=f"{RESULTS}/tables/accuracy_total.csv",
        splits=f"{RESULTS}/tables/accuracy_split.csv",
        figures=expand(
            f"{RESULTS}/figures/accuracy_total.{{format}}", format=["png", "pdf"]
        ),
        seal=f"{RESULTS}/seals/weigh_total_error.json",
    log:
        f"{RESULTS}/logs/weigh_total_error.log",
    benchmark:
        f"{RESULTS}/benchmarks/weigh_total_error.tsv"
    conda:
        ENVIRONMENT
    params:
        design=ACCURACY,
        joint=lambda wildcards: to_plain(
            accuracy.joint_of(TOTAL["scene"], ACCURACY_SETTINGS, ACCURACY_RUNS)
        ),
        measured=CONFIGURATION.statistics.control_variates,
        code=code_of("weigh_total_error"),
    message:
        "Weigh the total error of every way to a result"
    script:
        "../scripts/weigh_total_error.py"

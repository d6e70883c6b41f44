# Properties and open choices that vary together: `snakemake global_sensitivity --configfile config/global_sensitivity.yaml`.
# Without the configuration's `global_sensitivity` section no rule here has work.


rule global_sensitivity:
    input:
        f"{RESULTS}/tables/global_estimate.csv",
        expand(f"{RESULTS}/tables/global_{{table}}.csv", table=TOGETHER_TABLES),
        expand(
            f"{RESULTS}/figures/global_{{figure}}.{{format}}",
            figure=TOGETHER_FIGURES,
            format=["png", "pdf"],
        ),
        seals_of("estimate_together", "weigh_together", "draw_together"),
    message:
        "What matters when all varies together is known as far as it can be told"


rule compile_together:
    output:
        f"{RESULTS}/logs/global_kernels.txt",
    log:
        f"{RESULTS}/logs/compile_together.log",
    benchmark:
        f"{RESULTS}/benchmarks/compile_together.tsv"
    conda:
        ENVIRONMENT
    params:
        kernels=lambda wildcards: kernels_of(
            (each.case.effects, each.choices, each.numerics)
            for each in global_design.settings_of_choices(TOGETHER_DESIGN, config)
        ),
        code=code_of("compile_kernels"),
    message:
        "Compile the kernels of all choices"
    script:
        "../scripts/compile_kernels.py"


rule estimate_together:
    input:
        f"{RESULTS}/logs/global_kernels.txt",
    output:
        f"{RESULTS}/tables/global_estimate.csv",
        seal=f"{RESULTS}/seals/estimate_together.json",
    log:
        f"{RESULTS}/logs/estimate_together.log",
    benchmark:
        f"{RESULTS}/benchmarks/estimate_together.tsv"
    priority: 100
    conda:
        ENVIRONMENT
    params:
        design=lambda wildcards: to_plain(TOGETHER_DESIGN),
        configuration=lambda wildcards: {
            rock: together_keys(rock) for rock in TOGETHER_DESIGN.rocks
        },
        code=code_of("estimate_together"),
    message:
        "Estimate the core-minutes, by a few points of the design"
    script:
        "../scripts/estimate_together.py"


rule close_together:
    input:
        f"{RESULTS}/logs/global_kernels.txt",
    output:
        f"{RESULTS}/global_sensitivity/{{rock}}.{{first}}.nc",
        seal=f"{RESULTS}/seals/close_together/{{rock}}.{{first}}.json",
    log:
        f"{RESULTS}/logs/close_together/{{rock}}.{{first}}.log",
    benchmark:
        f"{RESULTS}/benchmarks/close_together/{{rock}}.{{first}}.tsv"
    conda:
        ENVIRONMENT
    params:
        design=lambda w: together_told(w.rock, w.first)["design"],
        configuration=lambda w: together_told(w.rock, w.first)["configuration"],
        rows=lambda w: together_told(w.rock, w.first)["rows"],
        code=code_of("close_together"),
    message:
        "Close {wildcards.rock} at the points of the rows from {wildcards.first} on"
    script:
        "../scripts/close_together.py"


rule weigh_together:
    input:
        closed=TOGETHER_FILES,
        seals=[together_seal(file) for file in TOGETHER_FILES],
    output:
        tables=expand(f"{RESULTS}/tables/global_{{table}}.csv", table=TOGETHER_TABLES),
        seal=f"{RESULTS}/seals/weigh_together.json",
    log:
        f"{RESULTS}/logs/weigh_together.log",
    benchmark:
        f"{RESULTS}/benchmarks/weigh_together.tsv"
    conda:
        ENVIRONMENT
    params:
        design=lambda wildcards: to_plain(TOGETHER_DESIGN),
        configuration=lambda wildcards: {"rocks": config["rocks"]},
        made_with=TOGETHER_WITH,
        code=code_of("weigh_together"),
    message:
        "Find indices, elasticities, and what conclusions hold"
    script:
        "../scripts/weigh_together.py"


rule draw_together:
    input:
        tables=expand(f"{RESULTS}/tables/global_{{table}}.csv", table=TOGETHER_TABLES),
        seals=seals_of("weigh_together"),
    output:
        figures=expand(
            f"{RESULTS}/figures/global_{{figure}}.{{format}}",
            figure=TOGETHER_FIGURES,
            format=["png", "pdf"],
        ),
        seal=f"{RESULTS}/seals/draw_together.json",
    log:
        f"{RESULTS}/logs/draw_together.log",
    benchmark:
        f"{RESULTS}/benchmarks/draw_together.tsv"
    conda:
        ENVIRONMENT
    params:
        titles=lambda wildcards: {name: ROCKS[name].title for name in ROCKS},
        code=code_of("draw_together"),
    message:
        "Draw what matters when all varies together"
    script:
        "../scripts/draw_together.py"

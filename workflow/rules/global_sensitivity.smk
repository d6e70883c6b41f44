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
    message:
        "What matters when all varies together is known as far as it can be told"


rule compile_together:
    output:
        f"{RESULTS}/logs/global_kernels.txt",
    params:
        kernels=lambda wildcards: kernels_of(
            (each.case.effects, each.choices, each.numerics)
            for each in global_design.settings_of_choices(TOGETHER_DESIGN, config)
        ),
    script:
        "../scripts/compile_kernels.py"


rule estimate_together:
    input:
        f"{RESULTS}/logs/global_kernels.txt",
    output:
        f"{RESULTS}/tables/global_estimate.csv",
    priority: 100
    params:
        design=lambda wildcards: to_plain(TOGETHER_DESIGN),
        configuration=lambda wildcards: {
            rock: together_keys(rock) for rock in TOGETHER_DESIGN.rocks
        },
    script:
        "../scripts/estimate_together.py"


rule close_together:
    input:
        f"{RESULTS}/logs/global_kernels.txt",
    output:
        f"{RESULTS}/global_sensitivity/{{rock}}.{{first}}.nc",
    params:
        design=lambda w: together_told(w.rock, w.first)["design"],
        configuration=lambda w: together_told(w.rock, w.first)["configuration"],
        rows=lambda w: together_told(w.rock, w.first)["rows"],
    script:
        "../scripts/close_together.py"


rule weigh_together:
    input:
        closed=TOGETHER_FILES,
    output:
        tables=expand(f"{RESULTS}/tables/global_{{table}}.csv", table=TOGETHER_TABLES),
    params:
        design=lambda wildcards: to_plain(TOGETHER_DESIGN),
        configuration=lambda wildcards: {"rocks": config["rocks"]},
    script:
        "../scripts/weigh_together.py"


rule draw_together:
    input:
        tables=expand(f"{RESULTS}/tables/global_{{table}}.csv", table=TOGETHER_TABLES),
    output:
        figures=expand(
            f"{RESULTS}/figures/global_{{figure}}.{{format}}",
            figure=TOGETHER_FIGURES,
            format=["png", "pdf"],
        ),
    params:
        titles=lambda wildcards: {name: ROCKS[name].title for name in ROCKS},
    script:
        "../scripts/draw_together.py"

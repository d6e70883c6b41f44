# Walls that are tilted or rotated: `snakemake misalignment --configfile config/misalignment.yaml`.
# Without a `misalignment` section there are no runs, and no rule here has work.


rule misalignment:
    input:
        f"{RESULTS}/misalignment.nc",
        f"{RESULTS}/tables/misalignment.csv",
        f"{RESULTS}/tables/misalignment_estimate.csv",
        expand(f"{RESULTS}/figures/misalignment.{{format}}", format=["png", "pdf"]),
        seals_of("estimate_misalignment", "weigh_misalignment", "draw_misalignment"),
    message:
        "What a tilt and a rotation of the walls do is known"


rule compile_misalignment:
    output:
        f"{RESULTS}/logs/misalignment_kernels.txt",
    log:
        f"{RESULTS}/logs/compile_misalignment.log",
    benchmark:
        f"{RESULTS}/benchmarks/compile_misalignment.tsv"
    conda:
        ENVIRONMENT
    params:
        kernels=kernels_of(
            (rock.effects, CONFIGURATION.choices, CONFIGURATION.numerics)
            for rock in ROCKS.values()
        ),
        code=code_of("compile_kernels"),
    message:
        "Compile the kernels of the study of misalignment"
    script:
        "../scripts/compile_kernels.py"


rule estimate_misalignment:
    input:
        f"{RESULTS}/logs/misalignment_kernels.txt",
    output:
        f"{RESULTS}/tables/misalignment_estimate.csv",
        seal=f"{RESULTS}/seals/estimate_misalignment.json",
    log:
        f"{RESULTS}/logs/estimate_misalignment.log",
    benchmark:
        f"{RESULTS}/benchmarks/estimate_misalignment.tsv"
    priority: 100
    conda:
        ENVIRONMENT
    params:
        settings=lambda wildcards: {
            f"{rock}.{label}": misalignment_of(rock, label)
            for rock in ROCKS
            for label in MISALIGNED_LABELS
        },
        code=code_of("estimate_misalignment"),
    message:
        "Estimate the time, by one joint of each rock and mismatch wavelength"
    script:
        "../scripts/estimate_misalignment.py"


rule close_misalignment:
    input:
        f"{RESULTS}/logs/misalignment_kernels.txt",
    output:
        f"{RESULTS}/misalignment/{{rock}}.{{label}}.nc",
        seal=f"{RESULTS}/seals/close_misalignment/{{rock}}.{{label}}.json",
    log:
        f"{RESULTS}/logs/close_misalignment/{{rock}}.{{label}}.log",
    benchmark:
        f"{RESULTS}/benchmarks/close_misalignment/{{rock}}.{{label}}.tsv"
    conda:
        ENVIRONMENT
    params:
        settings=lambda wildcards: misalignment_of(wildcards.rock, wildcards.label),
        code=code_of("close_misalignment"),
    message:
        "Close tilted and rotated walls of {wildcards.rock} with a mismatch of {wildcards.label}"
    script:
        "../scripts/close_misalignment.py"


rule weigh_misalignment:
    input:
        runs=expand(
            f"{RESULTS}/misalignment/{{rock}}.{{label}}.nc",
            rock=list(ROCKS),
            label=MISALIGNED_LABELS,
        ),
        seals=list(MISALIGNMENT_WITH),
    output:
        study=f"{RESULTS}/misalignment.nc",
        table=f"{RESULTS}/tables/misalignment.csv",
        seal=f"{RESULTS}/seals/weigh_misalignment.json",
    log:
        f"{RESULTS}/logs/weigh_misalignment.log",
    benchmark:
        f"{RESULTS}/benchmarks/weigh_misalignment.tsv"
    conda:
        ENVIRONMENT
    params:
        rocks=list(ROCKS),
        made_with=MISALIGNMENT_WITH,
        code=code_of("weigh_misalignment"),
    message:
        "Weigh what a tilt and a rotation do"
    script:
        "../scripts/weigh_misalignment.py"


rule draw_misalignment:
    input:
        f"{RESULTS}/tables/misalignment.csv",
        seals=seals_of("weigh_misalignment"),
    output:
        figures=expand(
            f"{RESULTS}/figures/misalignment.{{format}}", format=["png", "pdf"]
        ),
        seal=f"{RESULTS}/seals/draw_misalignment.json",
    log:
        f"{RESULTS}/logs/draw_misalignment.log",
    benchmark:
        f"{RESULTS}/benchmarks/draw_misalignment.tsv"
    conda:
        ENVIRONMENT
    params:
        figure="misalignment",
        code=code_of("draw_table"),
    message:
        "Draw what a tilt and a rotation do"
    script:
        "../scripts/draw_table.py"

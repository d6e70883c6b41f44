# Mated, natural and non-mated walls: `snakemake mismatch --configfile config/mismatch.yaml`.
# Without a `mismatch` section there are no runs, and no rule here has work.


rule mismatch:
    input:
        f"{RESULTS}/mismatch.nc",
        expand(
            f"{RESULTS}/tables/{{table}}",
            table=["mismatch.csv", "mismatch_shifts.csv", "mismatch_estimate.csv"],
        ),
        expand(f"{RESULTS}/figures/mismatch.{{format}}", format=["png", "pdf"]),
        seals_of("estimate_mismatch", "weigh_mismatch", "draw_mismatch"),
    message:
        "What mismatch and shift do is known"


rule compile_mismatch:
    output:
        f"{RESULTS}/logs/mismatch_kernels.txt",
    log:
        f"{RESULTS}/logs/compile_mismatch.log",
    benchmark:
        f"{RESULTS}/benchmarks/compile_mismatch.tsv"
    conda:
        ENVIRONMENT
    params:
        kernels=kernels_of(
            (rock.effects, CONFIGURATION.choices, CONFIGURATION.numerics)
            for rock in ROCKS.values()
        ),
        code=code_of("compile_kernels"),
    message:
        "Compile the kernels of the study of mismatch"
    script:
        "../scripts/compile_kernels.py"


rule estimate_mismatch:
    input:
        f"{RESULTS}/logs/mismatch_kernels.txt",
    output:
        f"{RESULTS}/tables/mismatch_estimate.csv",
        seal=f"{RESULTS}/seals/estimate_mismatch.json",
    log:
        f"{RESULTS}/logs/estimate_mismatch.log",
    benchmark:
        f"{RESULTS}/benchmarks/estimate_mismatch.tsv"
    priority: 100
    conda:
        ENVIRONMENT
    params:
        settings=lambda wildcards: {
            label: mismatch_of(next(iter(ROCKS)), label) for label in WAVELENGTHS
        },
        rocks=len(ROCKS),
        code=code_of("estimate_mismatch"),
    message:
        "Estimate the time, by one joint of the first rock at every condition"
    script:
        "../scripts/estimate_mismatch.py"


rule close_mismatch:
    input:
        f"{RESULTS}/logs/mismatch_kernels.txt",
    output:
        f"{RESULTS}/mismatch/{{rock}}.{{label}}.nc",
        seal=f"{RESULTS}/seals/close_mismatch/{{rock}}.{{label}}.json",
    log:
        f"{RESULTS}/logs/close_mismatch/{{rock}}.{{label}}.log",
    benchmark:
        f"{RESULTS}/benchmarks/close_mismatch/{{rock}}.{{label}}.tsv"
    conda:
        ENVIRONMENT
    params:
        settings=lambda wildcards: mismatch_of(wildcards.rock, wildcards.label),
        code=code_of("close_mismatch"),
    message:
        "Close the walls of {wildcards.rock} with a mismatch of {wildcards.label}"
    script:
        "../scripts/close_mismatch.py"


rule weigh_mismatch:
    input:
        runs=expand(
            f"{RESULTS}/mismatch/{{rock}}.{{label}}.nc",
            rock=list(ROCKS),
            label=list(WAVELENGTHS),
        ),
        seals=list(MISMATCH_WITH),
    output:
        study=f"{RESULTS}/mismatch.nc",
        table=f"{RESULTS}/tables/mismatch.csv",
        shifts=f"{RESULTS}/tables/mismatch_shifts.csv",
        seal=f"{RESULTS}/seals/weigh_mismatch.json",
    log:
        f"{RESULTS}/logs/weigh_mismatch.log",
    benchmark:
        f"{RESULTS}/benchmarks/weigh_mismatch.tsv"
    conda:
        ENVIRONMENT
    params:
        rocks=list(ROCKS),
        tolerance=MISMATCH.tolerance if MISMATCH else None,
        made_with=MISMATCH_WITH,
        code=code_of("weigh_mismatch"),
    message:
        "Weigh what mismatch and shift do"
    script:
        "../scripts/weigh_mismatch.py"


rule draw_mismatch:
    input:
        f"{RESULTS}/tables/mismatch.csv",
        seals=seals_of("weigh_mismatch"),
    output:
        figures=expand(f"{RESULTS}/figures/mismatch.{{format}}", format=["png", "pdf"]),
        seal=f"{RESULTS}/seals/draw_mismatch.json",
    log:
        f"{RESULTS}/logs/draw_mismatch.log",
    benchmark:
        f"{RESULTS}/benchmarks/draw_mismatch.tsv"
    conda:
        ENVIRONMENT
    params:
        figure="mismatch",
        code=code_of("draw_table"),
    message:
        "Draw what mismatch and shift do"
    script:
        "../scripts/draw_table.py"

# The scale effect: `snakemake size --configfile config/size.yaml`.
# Without a `size` section there are no runs, and no rule here has work.


rule size:
    input:
        f"{RESULTS}/size.nc",
        expand(f"{RESULTS}/tables/{{table}}.csv", table=[*SIZE_TABLES, "size_estimate"]),
        expand(f"{RESULTS}/figures/size.{{format}}", format=["png", "pdf"]),
        seals_of("estimate_size", "weigh_size", "draw_size"),
    message:
        "What patch length and grid spacing do is known"


rule compile_size:
    output:
        f"{RESULTS}/logs/size_kernels.txt",
    log:
        f"{RESULTS}/logs/compile_size.log",
    benchmark:
        f"{RESULTS}/benchmarks/compile_size.tsv"
    conda:
        ENVIRONMENT
    params:
        kernels=kernels_of(
            (rock.effects, CONFIGURATION.choices, CONFIGURATION.numerics)
            for rock in ROCKS.values()
        ),
        code=code_of("compile_kernels"),
    message:
        "Compile the kernels of the study of the scale effect"
    script:
        "../scripts/compile_kernels.py"


rule estimate_size:
    input:
        f"{RESULTS}/logs/size_kernels.txt",
    output:
        f"{RESULTS}/tables/size_estimate.csv",
        seal=f"{RESULTS}/seals/estimate_size.json",
    log:
        f"{RESULTS}/logs/estimate_size.log",
    benchmark:
        f"{RESULTS}/benchmarks/estimate_size.tsv"
    priority: 100
    conda:
        ENVIRONMENT
    params:
        settings=lambda wildcards: {
            spectrum: size_of(next(iter(ROCKS)), spectrum) for spectrum in SPECTRA
        },
        rocks=len(ROCKS),
        code=code_of("estimate_size"),
    message:
        "Estimate the time, by one joint of the first rock at the grid of the study"
    script:
        "../scripts/estimate_size.py"


rule close_size:
    input:
        f"{RESULTS}/logs/size_kernels.txt",
    output:
        f"{RESULTS}/size/{{rock}}.{{spectrum}}.nc",
        seal=f"{RESULTS}/seals/close_size/{{rock}}.{{spectrum}}.json",
    log:
        f"{RESULTS}/logs/close_size/{{rock}}.{{spectrum}}.log",
    benchmark:
        f"{RESULTS}/benchmarks/close_size/{{rock}}.{{spectrum}}.tsv"
    conda:
        ENVIRONMENT
    params:
        settings=lambda wildcards: size_of(wildcards.rock, wildcards.spectrum),
        code=code_of("close_size"),
    message:
        "Close the nested patches of {wildcards.rock}, spectrum {wildcards.spectrum}"
    script:
        "../scripts/close_size.py"


rule weigh_size:
    input:
        runs=expand(
            f"{RESULTS}/size/{{rock}}.{{spectrum}}.nc",
            rock=list(ROCKS),
            spectrum=SPECTRA,
        ),
        seals=list(SIZE_WITH),
    output:
        study=f"{RESULTS}/size.nc",
        tables=expand(f"{RESULTS}/tables/{{table}}.csv", table=SIZE_TABLES),
        seal=f"{RESULTS}/seals/weigh_size.json",
    log:
        f"{RESULTS}/logs/weigh_size.log",
    benchmark:
        f"{RESULTS}/benchmarks/weigh_size.tsv"
    conda:
        ENVIRONMENT
    params:
        base=(
            [
                CONFIGURATION.grid.cells_x * CONFIGURATION.grid.spacing,
                CONFIGURATION.grid.spacing,
            ]
        ),
        spectra=lambda wildcards: to_plain(SIZE.spectra),
        rocks=lambda wildcards: {
            name: [rock.jrc, rock.intact.compressive_strength, rock.max_normal_stress]
            for name, rock in ROCKS.items()
        },
        strength_ratio=CONFIGURATION.output.wall_strength_ratio,
        made_with=SIZE_WITH,
        code=code_of("weigh_size"),
    message:
        "Weigh what patch length and grid spacing do"
    script:
        "../scripts/weigh_size.py"


rule draw_size:
    input:
        f"{RESULTS}/tables/size.csv",
        seals=seals_of("weigh_size"),
    output:
        figures=expand(f"{RESULTS}/figures/size.{{format}}", format=["png", "pdf"]),
        seal=f"{RESULTS}/seals/draw_size.json",
    log:
        f"{RESULTS}/logs/draw_size.log",
    benchmark:
        f"{RESULTS}/benchmarks/draw_size.tsv"
    conda:
        ENVIRONMENT
    params:
        figure="size",
        code=code_of("draw_table"),
    message:
        "Draw what patch length and grid spacing do"
    script:
        "../scripts/draw_table.py"

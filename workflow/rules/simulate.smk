# Surfaces of each case, and their closure: in blocks of realisations, named by their first.


rule compile_kernels:
    output:
        f"{RESULTS}/logs/kernels.txt",
    log:
        f"{RESULTS}/logs/compile_kernels.log",
    benchmark:
        f"{RESULTS}/benchmarks/compile_kernels.tsv"
    conda:
        ENVIRONMENT
    params:
        effects=config["effects"],
        choices=config["choices"],
        solver=config["numerics"]["solver"],
        breakage=config["numerics"]["breakage"],
        code=SOLVER_CODE,
    message:
        "Compile the kernels (about half a minute when they are new, else a second)"
    script:
        "../scripts/compile_kernels.py"


rule make_surfaces:
    output:
        f"{RESULTS}/cases/{{case}}.{{first}}.surfaces.nc",
    log:
        f"{RESULTS}/logs/make_surfaces/{{case}}.{{first}}.log",
    benchmark:
        f"{RESULTS}/benchmarks/make_surfaces/{{case}}.{{first}}.tsv"
    conda:
        ENVIRONMENT
    params:
        settings=lambda wildcards: settings.surface_settings(
            config, CASES[wildcards.case], BLOCKS[wildcards.first], SURFACE_CODE
        ),
    message:
        "Generate the surface pairs of {wildcards.case} from realisation {wildcards.first} on"
    script:
        "../scripts/make_surfaces.py"


rule close_surfaces:
    input:
        surfaces=lambda wildcards: f"{RESULTS}/cases/{CASES[wildcards.case].surface}.{wildcards.first}.surfaces.nc",
        kernels=ancient(f"{RESULTS}/logs/kernels.txt"),
    output:
        f"{RESULTS}/cases/{{case}}.{{first}}.nc",
    log:
        f"{RESULTS}/logs/close_surfaces/{{case}}.{{first}}.log",
    benchmark:
        f"{RESULTS}/benchmarks/close_surfaces/{{case}}.{{first}}.tsv"
    conda:
        ENVIRONMENT
    params:
        settings=lambda wildcards: settings.block_settings(
            config,
            CASES,
            wildcards.case,
            BLOCKS[wildcards.first],
            SURFACE_CODE,
            SOLVER_CODE,
        ),
    message:
        "Close the surface pairs of {wildcards.case} from realisation {wildcards.first} on"
    script:
        "../scripts/close_surfaces.py"


rule aggregate:
    input:
        expand(f"{RESULTS}/cases/{{case}}.{{first}}.nc", case=CASES, first=BLOCKS),
    output:
        f"{RESULTS}/study.nc",
    log:
        f"{RESULTS}/logs/aggregate.log",
    benchmark:
        f"{RESULTS}/benchmarks/aggregate.tsv"
    conda:
        ENVIRONMENT
    params:
        configuration=config,
        surface_code=SURFACE_CODE,
        solver_code=SOLVER_CODE,
    message:
        "Put all cases into one dataset"
    script:
        "../scripts/aggregate.py"

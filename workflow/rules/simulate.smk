# Surfaces of each case, and their closure.


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
        f"{RESULTS}/cases/{{case}}.surfaces.nc",
    log:
        f"{RESULTS}/logs/make_surfaces/{{case}}.log",
    benchmark:
        f"{RESULTS}/benchmarks/make_surfaces/{{case}}.tsv"
    conda:
        ENVIRONMENT
    params:
        seeds=lambda wildcards: [
            cases.wall_seed(config, CASES[wildcards.case], realization)
            for realization in range(config["study"]["realizations"])
        ],
        jrc=lambda wildcards: CASES[wildcards.case].jrc,
        grid=config["grid"],
        surface=config["surface"],
        code=SURFACE_CODE,
    message:
        "Generate the surface pairs of {wildcards.case}"
    script:
        "../scripts/make_surfaces.py"


rule close_surfaces:
    input:
        surfaces=lambda wildcards: f"{RESULTS}/cases/{CASES[wildcards.case].surface}.surfaces.nc",
        kernels=ancient(f"{RESULTS}/logs/kernels.txt"),
    output:
        f"{RESULTS}/cases/{{case}}.nc",
    log:
        f"{RESULTS}/logs/close_surfaces/{{case}}.log",
    benchmark:
        f"{RESULTS}/benchmarks/close_surfaces/{{case}}.tsv"
    conda:
        ENVIRONMENT
    params:
        case=lambda wildcards: CASES[wildcards.case]._asdict(),
        cycles=config["study"]["cycles"],
        seating_stress_MPa=config["seating_stress_MPa"],
        effects=config["effects"],
        choices=config["choices"],
        numerics=config["numerics"],
        stress_points=config["output"]["stress_points"],
        largest_stress_MPa=config["output"]["largest_stress_MPa"],
        code=SOLVER_CODE,
    message:
        "Close the surface pairs of {wildcards.case}"
    script:
        "../scripts/close_surfaces.py"


rule aggregate:
    input:
        expand(f"{RESULTS}/cases/{{case}}.nc", case=CASES),
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
        cases=[case._asdict() for case in CASES.values()],
        code=SOLVER_CODE,
    message:
        "Put all cases into one dataset"
    script:
        "../scripts/aggregate.py"

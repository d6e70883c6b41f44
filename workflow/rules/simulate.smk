# Surfaces of each case, and their closure.


rule compile_kernels:
    message:
        "Compile the kernels (about half a minute when they are new, else a second)"
    output:
        f"{RESULTS}/logs/kernels.txt",
    params:
        effects=config["effects"],
        choices=config["choices"],
        solver=config["numerics"]["solver"],
        code=SOLVER_CODE,
    log:
        f"{RESULTS}/logs/compile_kernels.log",
    benchmark:
        f"{RESULTS}/benchmarks/compile_kernels.tsv"
    conda:
        ENVIRONMENT
    script:
        "../scripts/compile_kernels.py"


rule make_surfaces:
    message:
        "Generate the surface pairs of {wildcards.case}"
    output:
        f"{RESULTS}/cases/{{case}}.surfaces.nc",
    params:
        seeds=lambda wildcards: [
            cases.wall_seed(config, CASES[wildcards.case], realization)
            for realization in range(config["study"]["realizations"])
        ],
        jrc=lambda wildcards: CASES[wildcards.case].jrc,
        grid=config["grid"],
        surface=config["surface"],
        code=SURFACE_CODE,
    log:
        f"{RESULTS}/logs/make_surfaces/{{case}}.log",
    benchmark:
        f"{RESULTS}/benchmarks/make_surfaces/{{case}}.tsv"
    conda:
        ENVIRONMENT
    script:
        "../scripts/make_surfaces.py"


rule close_surfaces:
    message:
        "Close the surface pairs of {wildcards.case}"
    input:
        surfaces=lambda wildcards: f"{RESULTS}/cases/{CASES[wildcards.case].surface}.surfaces.nc",
        kernels=ancient(f"{RESULTS}/logs/kernels.txt"),
    output:
        f"{RESULTS}/cases/{{case}}.nc",
    params:
        case=lambda wildcards: CASES[wildcards.case]._asdict(),
        cycles=config["study"]["cycles"],
        seating_stress_MPa=config["seating_stress_MPa"],
        effects=config["effects"],
        choices=config["choices"],
        numerics=config["numerics"],
        stress_points=config["output"]["stress_points"],
        largest_stress_MPa=max(rock["max_normal_stress_MPa"] for rock in ROCKS.values()),
        code=SOLVER_CODE,
    log:
        f"{RESULTS}/logs/close_surfaces/{{case}}.log",
    benchmark:
        f"{RESULTS}/benchmarks/close_surfaces/{{case}}.tsv"
    conda:
        ENVIRONMENT
    script:
        "../scripts/close_surfaces.py"


rule aggregate:
    message:
        "Put all cases into one dataset"
    input:
        expand(RESULTS + "/cases/{case}.nc", case=CASES),
    output:
        f"{RESULTS}/study.nc",
    params:
        configuration=config,
        cases=[case._asdict() for case in CASES.values()],
        code=SOLVER_CODE,
    log:
        f"{RESULTS}/logs/aggregate.log",
    benchmark:
        f"{RESULTS}/benchmarks/aggregate.tsv"
    conda:
        ENVIRONMENT
    script:
        "../scripts/aggregate.py"

# Surfaces of each case, and their closure: in blocks of realisations, named by their first.
# The study's own are in the folder cases, those of its pool in pool.
from jointclosure.effects.choice import possible_scenes

# what jobs are told whose seals are held against it
AGGREGATED = {
    ensemble: {
        "ensemble": ensemble,
        "configuration": config,
        "surface_code": SURFACE_CODE,
        "solver_code": SOLVER_CODE,
        "code": code_of("aggregate"),
    }
    for ensemble in ENSEMBLES
}
STUDY_WITH = {
    AGGREGATE_SEALS[ensemble]: settings_digest(told)
    for ensemble, told in AGGREGATED.items()
}


CHOSEN_WITH = {
    seals_of(f"choose_effects/{rock}")[0]: settings_digest(choosing(rock))
    for rock in (ROCKS if AUTO else [])
}


WALLS_WITH = {
    seals_of(f"prepare_walls/{name}")[0]: settings_digest(preparing(name))
    for name, rock in ROCKS.items()
    if rock.walls
}


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
        kernels=kernels_of(
            (scene, CONFIGURATION.choices, CONFIGURATION.numerics)
            for rock in ROCKS.values()
            for scene in possible_scenes(rock.effects, chosen=AUTO)
        ),
        code=code_of("compile_kernels"),
    message:
        "Compile the kernels (about half a minute when they are new, else a second)"
    script:
        "../scripts/compile_kernels.py"


rule make_surfaces:
    output:
        f"{RESULTS}/{{ensemble}}/{{case}}.{{first}}.surfaces.nc",
    log:
        f"{RESULTS}/logs/make_surfaces/{{ensemble}}/{{case}}.{{first}}.log",
    benchmark:
        f"{RESULTS}/benchmarks/make_surfaces/{{ensemble}}/{{case}}.{{first}}.tsv"
    conda:
        ENVIRONMENT
    params:
        settings=lambda wildcards: surfaces_of(
            wildcards.ensemble, wildcards.case, wildcards.first
        ),
    message:
        "Generate the surface pairs of {wildcards.case} from realisation {wildcards.first} on"
    script:
        "../scripts/make_surfaces.py"


rule choose_effects:
    input:
        f"{RESULTS}/logs/kernels.txt",
    output:
        chosen=f"{RESULTS}/effects_of/{{rock}}.json",
        closed=f"{RESULTS}/effects_of/{{rock}}.nc",
        seal=f"{RESULTS}/seals/choose_effects/{{rock}}.json",
    log:
        f"{RESULTS}/logs/choose_effects/{{rock}}.log",
    benchmark:
        f"{RESULTS}/benchmarks/choose_effects/{{rock}}.tsv"
    conda:
        ENVIRONMENT
    params:
        settings=lambda wildcards: choosing(wildcards.rock)["settings"],
        code=code_of("choose_effects"),
    message:
        "Choose the effects that matter for {wildcards.rock}, by a pilot"
    script:
        "../scripts/choose_effects.py"


rule close_surfaces:
    input:
        effects=lambda wildcards: (
            f"{RESULTS}/effects_of/{rock_of(wildcards)}.json" if AUTO else []
        ),
        before=lambda wildcards: (
            f"{RESULTS}/effects_of/{rock_of(wildcards)}.nc"
            if AUTO and wildcards.ensemble == "cases"
            else []
        ),
        surfaces=closed_surfaces,
        kernels=f"{RESULTS}/logs/kernels.txt",
        seals=lambda wildcards: (
            seals_of(f"choose_effects/{rock_of(wildcards)}") if AUTO else []
        ),
    output:
        f"{RESULTS}/{{ensemble}}/{{case}}.{{first}}.nc",
    log:
        f"{RESULTS}/logs/close_surfaces/{{ensemble}}/{{case}}.{{first}}.log",
    benchmark:
        f"{RESULTS}/benchmarks/close_surfaces/{{ensemble}}/{{case}}.{{first}}.tsv"
    conda:
        ENVIRONMENT
    params:
        settings=lambda wildcards: to_plain(
            closure_of(
                wildcards.ensemble,
                wildcards.case,
                BLOCKS[wildcards.ensemble][wildcards.first],
            )
        ),
        made_with=lambda wildcards: CHOSEN_WITH,
    message:
        "Close the surface pairs of {wildcards.case} from realisation {wildcards.first} on"
    script:
        "../scripts/close_surfaces.py"


rule aggregate:
    input:
        cases=closed_blocks("cases"),
        effects=expand(
            f"{RESULTS}/effects_of/{{rock}}.json", rock=ROCKS if AUTO else []
        ),
        walls=[
            f"{RESULTS}/walls/{name}.nc" for name, rock in ROCKS.items() if rock.walls
        ],
        seals=[*CHOSEN_WITH, *WALLS_WITH],
    output:
        f"{RESULTS}/study.nc",
        seal=f"{RESULTS}/seals/aggregate.json",
    log:
        f"{RESULTS}/logs/aggregate.log",
    benchmark:
        f"{RESULTS}/benchmarks/aggregate.tsv"
    conda:
        ENVIRONMENT
    params:
        **AGGREGATED["cases"],
        made_with=CHOSEN_WITH | WALLS_WITH,
    message:
        "Put all cases into one dataset"
    script:
        "../scripts/aggregate.py"


if "pool" in ENSEMBLES:

    use rule aggregate as aggregate_pool with:
        input:
            cases=closed_blocks("pool"),
            effects=rules.aggregate.input.effects,
            walls=rules.aggregate.input.walls,
            seals=rules.aggregate.input.seals,
        output:
            f"{RESULTS}/pool.nc",
            seal=f"{RESULTS}/seals/aggregate_pool.json",
        log:
            f"{RESULTS}/logs/aggregate_pool.log",
        benchmark:
            f"{RESULTS}/benchmarks/aggregate_pool.tsv"
        params:
            **AGGREGATED["pool"],
            made_with=CHOSEN_WITH | WALLS_WITH,
        message:
            "Put all cases of the pool into one dataset"

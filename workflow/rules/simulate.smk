# Surfaces of each case, and their closure: in blocks of realisations, named by their first.
# Those of the study are in the folder cases, those of its pool in pool.
from jointclosure.engine.choice import possible_scenes


rule compile_kernels:
    output:
        f"{RESULTS}/logs/kernels.txt",
    priority: EARLY
    params:
        kernels=kernels_of(
            (scene, CONFIGURATION.choices, CONFIGURATION.numerics)
            for rock in ROCKS.values()
            for scene in possible_scenes(rock.effects, chosen=AUTO)
        ),
    script:
        "../scripts/compile_kernels.py"


rule make_surfaces:
    output:
        f"{RESULTS}/{{ensemble}}/{{case}}.{{first}}.surfaces.nc",
    priority: lambda wildcards: EARLY if wildcards.ensemble == "cases" else 0
    params:
        settings=lambda wildcards: surfaces_of(
            wildcards.ensemble, wildcards.case, wildcards.first
        ),
    script:
        "../scripts/make_surfaces.py"


rule choose_effects:
    input:
        ancient(f"{RESULTS}/logs/kernels.txt"),
    output:
        chosen=f"{RESULTS}/effects_of/{{rock}}.json",
        closed=f"{RESULTS}/effects_of/{{rock}}.nc",
    priority: EARLY
    params:
        settings=lambda wildcards: closures_of_rock(wildcards.rock),
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
        kernels=ancient(f"{RESULTS}/logs/kernels.txt"),
    output:
        f"{RESULTS}/{{ensemble}}/{{case}}.{{first}}.nc",
    priority: lambda wildcards: EARLY if wildcards.ensemble == "cases" else 0
    params:
        settings=lambda wildcards: to_plain(
            closure_of(
                wildcards.ensemble,
                wildcards.case,
                BLOCKS[wildcards.ensemble][wildcards.first],
            )
        ),
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
    output:
        f"{RESULTS}/study.nc",
    priority: EARLY
    params:
        ensemble="cases",
        configuration=slices.closed_keys(config),
        surface_code=SURFACE_CODE,
        solver_code=SOLVER_CODE,
    script:
        "../scripts/aggregate.py"


if "pool" in ENSEMBLES:

    use rule aggregate as aggregate_pool with:
        input:
            cases=closed_blocks("pool"),
            effects=rules.aggregate.input.effects,
            walls=rules.aggregate.input.walls,
        output:
            f"{RESULTS}/pool.nc",
        priority: 0
        params:
            ensemble="pool",

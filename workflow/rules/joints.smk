# Joints of the study and of its pool: one job closes an ensemble by processes, into a cache of files that
# Snakemake does not know. On a cluster each of these files is a job of its own before it.


wildcard_constraints:
    kind="|".join(["effects_of", *ENSEMBLES, *EXPERIMENTS]),


rule compile_kernels:
    output:
        f"{RESULTS}/logs/{{kind}}_kernels.txt",
    params:
        kernels=lambda w: (ENSEMBLES | DESIGNS)[w.kind].kernels(),
    script:
        "../scripts/compile_kernels.py"


rule close_block:
    input:
        lambda w: WALLS if w.kind in ENSEMBLES else [],
        lambda w: closed_apart(*PILOTS) if w.kind in ENSEMBLES else [],
        kernels=lambda w: ancient(
            f"{RESULTS}/logs/{w.kind.replace('effects_of', 'cases')}_kernels.txt"
        ),
    output:
        f"{RESULTS}/{{kind}}/{{block}}.nc",
    params:
        key=lambda w: CACHED(w.kind)[f"{w.kind}/{w.block}"].key,
    script:
        "../scripts/close_block.py"


rule close_study:
    input:
        walls=WALLS,
        closed=closed_apart(*PILOTS, *CACHED("cases")),
    output:
        joints=f"{RESULTS}/study.nc",
        first_walls=f"{RESULTS}/first_walls.nc",
    priority: EARLY
    threads: workflow.cores
    params:
        ensemble="cases",
        configuration=closed_keys(config),
        joints=keys_of("effects_of", "cases"),
    script:
        "../scripts/close_ensemble.py"


if "pool" in ENSEMBLES:

    use rule close_study as close_pool with:
        input:
            walls=WALLS,
            closed=closed_apart(*PILOTS, *CACHED("pool")),
        output:
            joints=f"{RESULTS}/pool.nc",
        priority: 0  # after the study, as both take all cores
        params:
            ensemble="pool",
            configuration=closed_keys(config),
            joints=keys_of("effects_of", "pool"),

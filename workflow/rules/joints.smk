# Joints of the study and of its pool: one job closes an ensemble by processes, into a cache of files that
# Snakemake does not know. On a cluster each of these files is a job of its own before it.


wildcard_constraints:
    kind="|".join(["effects_of", *ENSEMBLES, *EXPERIMENTS]),
    kernels="[0-9a-f]{8}",


rule compile_kernels:
    output:
        f"{RESULTS}/logs/{{kind}}_kernels_{{kernels}}.txt",
    params:
        kernels=lambda w: (ENSEMBLES | DESIGNS)[w.kind].kernels(),
    script:
        "../scripts/compile_kernels.py"


rule close_block:
    input:
        lambda w: WALLS if w.kind in ("effects_of", *ENSEMBLES) else [],
        lambda w: closed_apart(*PILOTS) if w.kind in ENSEMBLES else [],
        kernels=lambda w: ancient(kernels_file(w.kind)),
    output:
        f"{RESULTS}/{{kind}}/{{block}}.nc",
    params:
        key=lambda w: CACHED(w.kind)[f"{w.kind}/{w.block}"].key,
    script:
        "../scripts/close_block.py"


for NAME in ENSEMBLES:

    rule:
        name:
            f"close_{Path(dataset_of(NAME)).stem}"
        input:
            walls=WALLS,
            closed=closed_apart(*PILOTS, *CACHED(NAME)),
        output:
            **({"first_walls": f"{RESULTS}/first_walls.nc"} if NAME == "cases" else {}),
            joints=f"{RESULTS}/{dataset_of(NAME)}",
        priority: 0 if NAME == "pool" else EARLY  # the pool comes last, as each takes all cores
        threads: workflow.cores
        params:
            ensemble=NAME,
            configuration=closed_keys(config),
            joints=keys_of("effects_of", NAME),
        script:
            "../scripts/close_ensemble.py"


if "finest" in ENSEMBLES:

    rule price_accuracy:
        input:
            walls=WALLS,
        output:
            f"{RESULTS}/tables/accuracy_price.csv",
        params:
            joints=lambda w: digest(
                *(
                    first.key
                    for name in ("cases", "finest")
                    for first in ENSEMBLES[name].firsts()
                )
            ),
        script:
            "../scripts/price_accuracy.py"

# Simulation of the joints of every case over its load cycles, and one dataset of all cases.


rule compile_kernels:
    output:
        f"{RESULTS}/kernels/{{scene}}.{{peaks}}.{{bound}}.{{solver}}.{{breakage}}.txt",
    log:
        f"{RESULTS}/logs/compile_kernels/{{scene}}.{{peaks}}.{{bound}}.{{solver}}.{{breakage}}.log",
    conda:
        ENVIRONMENT
    # alone: two processes that compile into an empty cache could take each other's machine code
    threads: workflow.cores
    params:
        machine_code=cache_folder().name,  # a digest of the kernels and of what compiles them
        code=code("compile_kernels.py", titles=False),
    message:
        "Load the kernels of {wildcards.scene}; new ones are compiled in about a minute"
    script:
        "../scripts/compile_kernels.py"


rule choose_effects:
    input:
        surfaces=lambda w: surfaces_of_choice(w.rock),
        kernels=lambda w: kernel_files([choice_of(w.rock).point], chosen=True),
    output:
        f"{RESULTS}/effects/{{rock}}.nc",
    log:
        f"{RESULTS}/logs/choose_effects/{{rock}}.log",
    priority: 2
    group:
        "closures"
    conda:
        ENVIRONMENT
    params:
        choice=lambda w: choice_of(w.rock),
        key=lambda w: effects_key(w.rock),
        flow=STUDY.flow,
        code=code("choose_effects.py", titles=False),
    message:
        "Choose the effects that the cases of {wildcards.rock} call for"
    script:
        "../scripts/choose_effects.py"


# The processor time of each joint is in its dataset. A benchmark directive would take another
# twentieth of the time of a study, as it reads the memory of each process twice a second.
rule close_joints:
    input:
        surfaces=lambda w: surfaces_of(w.ensemble, case_of(w).label, w.first, w.last),
        effects=lambda w: (
            f"{RESULTS}/effects/{w.rock}.nc"
            if CHOSEN and w.ensemble != "finest"
            else []
        ),
        kernels=lambda w: kernel_files(
            [point_of(w)], chosen=CHOSEN and w.ensemble != "finest"
        ),
    output:
        f"{RESULTS}/{{ensemble}}/{{rock}}-{{change}}.{{first}}-{{last}}.nc",
    log:
        f"{RESULTS}/logs/close_joints/{{ensemble}}/{{rock}}-{{change}}.{{first}}-{{last}}.log",
    priority: lambda w: priority_of(w.ensemble)
    group:
        "closures"
    conda:
        ENVIRONMENT
    params:
        point=point_of,
        flow=lambda w: ENSEMBLES[w.ensemble].flow,
        key=lambda w: keys_of(w.ensemble)[case_of(w).label],
        effects_key=lambda w: effects_key(w.rock) if CHOSEN else None,
        code=code("close_joints.py", titles=False),
    message:
        "Simulate the joints of {wildcards.rock}, {wildcards.change} ({wildcards.ensemble})"
    script:
        "../scripts/close_joints.py"


rule aggregate:
    input:
        joints=lambda w: closed_joints("cases"),
        effects=(
            collect(f"{RESULTS}/effects/{{rock}}.nc", rock=STUDY.rocks)
            if CHOSEN
            else []
        ),
        walls=collect(f"{RESULTS}/walls/{{rock}}.nc", rock=SCANNED),
        plan=lambda w: reached_plan(),
    output:
        f"{RESULTS}/study.nc",
    log:
        f"{RESULTS}/logs/aggregate.log",
    priority: 2
    conda:
        ENVIRONMENT
    params:
        ensemble="cases",
        cases=list(CASES["cases"].values()),
        key_of=keys_of("cases"),
        key=KEYS["study"],
        effects_keys={rock: effects_key(rock) for rock in STUDY.rocks} if CHOSEN else {},
        walls_keys={rock: walls_key(rock) for rock in SCANNED},
        stated=configuration_text(closed_keys(STUDY.stated)),
        code=code("aggregate.py", titles=False),
    message:
        "Join all cases of the study in one dataset"
    script:
        "../scripts/aggregate.py"


if POOL == "pool":

    use rule aggregate as aggregate_pool with:
        input:
            joints=lambda w: closed_joints("pool"),
            effects=(
                collect(f"{RESULTS}/effects/{{rock}}.nc", rock=STUDY.rocks)
                if CHOSEN
                else []
            ),
            walls=collect(f"{RESULTS}/walls/{{rock}}.nc", rock=SCANNED),
        output:
            f"{RESULTS}/pool.nc",
        log:
            f"{RESULTS}/logs/aggregate_pool.log",
        priority: 0
        params:
            ensemble="pool",
            cases=list(CASES["pool"].values()),
            key_of=keys_of("pool"),
            key=KEYS["pool"],
            effects_keys=(
                {rock: effects_key(rock) for rock in STUDY.rocks} if CHOSEN else {}
            ),
            walls_keys={rock: walls_key(rock) for rock in SCANNED},
            stated=configuration_text(closed_keys(STUDY.stated)),
            code=code("aggregate.py", titles=False),
        message:
            "Join all cases of the pool in one dataset"

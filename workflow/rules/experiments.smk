# Experiments: points are closed by one engine, and put into tables and figures. The rules have work for
# those experiments whose section the configuration has: `snakemake size --configfile config/size.yaml`.


wildcard_constraints:
    experiment="|".join(EXPERIMENTS) or "none",
    job="[A-Za-z0-9_.-]+",
    round="[a-z][a-z0-9_]*",


rule compile_experiment:
    output:
        f"{RESULTS}/logs/{{experiment}}_kernels.txt",
    log:
        f"{RESULTS}/logs/compile_{{experiment}}.log",
    benchmark:
        f"{RESULTS}/benchmarks/compile_{{experiment}}.tsv"
    conda:
        ENVIRONMENT
    params:
        kernels=lambda w: DESIGNS[w.experiment].kernels(),
        code=code_of("compile_kernels"),
    message:
        "Compile the kernels of the experiment {wildcards.experiment}"
    script:
        "../scripts/compile_kernels.py"


rule close_points:
    input:
        f"{RESULTS}/logs/{{experiment}}_kernels.txt",
    output:
        f"{RESULTS}/{{experiment}}/{{job}}.nc",
        seal=f"{RESULTS}/seals/close_{{experiment}}/{{job}}.json",
    log:
        f"{RESULTS}/logs/close_{{experiment}}/{{job}}.log",
    benchmark:
        f"{RESULTS}/benchmarks/close_{{experiment}}/{{job}}.tsv"
    conda:
        ENVIRONMENT
    params:
        points=lambda w: closing(w.experiment, w.job)["points"],
        quantities=lambda w: closing(w.experiment, w.job)["quantities"],
        code=code_of("close_points"),
    message:
        "Close the joints of {wildcards.job} ({wildcards.experiment})"
    script:
        "../scripts/close_points.py"


checkpoint rank_round:
    input:
        joints=lambda w: joints_of(
            w.experiment, jobs_of_round(w.experiment, number_of(w))
        ),
        before=lambda w: [
            table_file(ranking)
            for ranking in rankings_before(w.experiment, number_of(w))
        ],
        files=lambda w: list(DESIGNS[w.experiment].files.values()),
        seals=sealed_for_round,
    output:
        f"{RESULTS}/tables/{{experiment}}_round_{{round}}.csv",
        seal=f"{RESULTS}/seals/{{experiment}}_round_{{round}}.json",
    log:
        f"{RESULTS}/logs/{{experiment}}_round_{{round}}.log",
    benchmark:
        f"{RESULTS}/benchmarks/{{experiment}}_round_{{round}}.tsv"
    conda:
        ENVIRONMENT
    params:
        parameters=lambda w: DESIGNS[w.experiment].parameters,
        files=lambda w: dict(DESIGNS[w.experiment].files),
        number=number_of,
        entrants=lambda w: entrants_of(w.experiment, number_of(w)),
        made_with=lambda w: closed_with(
            w.experiment, jobs_of_round(w.experiment, number_of(w))
        ),
        code=lambda w: code_of_experiment(w.experiment, "rank_round"),
    message:
        "Rank those that entered the round {wildcards.round} ({wildcards.experiment})"
    script:
        "../scripts/rank_round.py"


for NAME, EXPERIMENT in EXPERIMENTS.items():
    RANKINGS = [ranking_job(NAME, number) for number in range(len(round_names(NAME)))]

    rule:
        name:
            f"estimate_{NAME}"
        input:
            f"{RESULTS}/logs/{NAME}_kernels.txt",
        output:
            f"{RESULTS}/tables/{NAME}_estimate.csv",
            seal=f"{RESULTS}/seals/estimate_{NAME}.json",
        log:
            f"{RESULTS}/logs/estimate_{NAME}.log",
        benchmark:
            f"{RESULTS}/benchmarks/estimate_{NAME}.tsv"
        priority: 100
        conda:
            ENVIRONMENT
        params:
            samples=lambda w, name=NAME: packed_samples(name),
            at_most=bool(RANKINGS),
            code=code_of("estimate_points"),
        message:
            f"Estimate the time of the experiment {NAME}, by a few of its joints"
        script:
            "../scripts/estimate_points.py"

    rule:
        name:
            f"tabulate_{NAME}"
        input:
            joints=lambda w, name=NAME: joints_of(name, jobs_of(name)),
            rounds=[table_file(ranking) for ranking in RANKINGS],
            files=list(DESIGNS[NAME].files.values()),
            seals=lambda w, name=NAME, rankings=RANKINGS: [
                closing_seal(name, job) for job in jobs_of(name)
            ]
            + seals_of(*rankings),
        output:
            joints=f"{RESULTS}/{NAME}.nc",
            tables=[table_file(table) for table in DESIGNS[NAME].tables],
            seal=f"{RESULTS}/seals/tabulate_{NAME}.json",
        log:
            f"{RESULTS}/logs/tabulate_{NAME}.log",
        benchmark:
            f"{RESULTS}/benchmarks/tabulate_{NAME}.tsv"
        conda:
            ENVIRONMENT
        params:
            experiment=NAME,
            parameters=DESIGNS[NAME].parameters,
            files=dict(DESIGNS[NAME].files),
            made_with=lambda w, name=NAME: closed_with(name, jobs_of(name)),
            code=code_of_experiment(NAME, "tabulate_points"),
        message:
            f"Find {EXPERIMENT.title}"
        script:
            "../scripts/tabulate_points.py"

    rule:
        name:
            f"draw_{NAME}"
        input:
            tables=[table_file(table) for table in DESIGNS[NAME].tables],
            files=list(DESIGNS[NAME].files.values()),
            seals=seals_of(f"tabulate_{NAME}"),
        output:
            figures=[
                f"{RESULTS}/figures/{figure}.{format}"
                for figure in DESIGNS[NAME].figures
                for format in ("png", "pdf")
            ],
            seal=f"{RESULTS}/seals/draw_{NAME}.json",
        log:
            f"{RESULTS}/logs/draw_{NAME}.log",
        benchmark:
            f"{RESULTS}/benchmarks/draw_{NAME}.tsv"
        conda:
            ENVIRONMENT
        params:
            experiment=NAME,
            parameters=DESIGNS[NAME].parameters,
            files=dict(DESIGNS[NAME].files),
            code=code_of_experiment(NAME, "draw_experiment"),
        message:
            f"Draw {EXPERIMENT.title}"
        script:
            "../scripts/draw_experiment.py"

    rule:
        name:
            NAME
        input:
            f"{RESULTS}/{NAME}.nc",
            f"{RESULTS}/tables/{NAME}_estimate.csv",
            [table_file(table) for table in DESIGNS[NAME].tables],
            [
                f"{RESULTS}/figures/{figure}.{format}"
                for figure in DESIGNS[NAME].figures
                for format in ("png", "pdf")
            ],
            seals_of(f"estimate_{NAME}", f"tabulate_{NAME}", f"draw_{NAME}"),
        message:
            f"The experiment {NAME} is complete: {EXPERIMENT.title}"

# Experiments: points are closed by one engine, and put into tables and figures. The rules have work for
# those experiments whose section the configuration has: `snakemake size --configfile config/size.yaml`.


wildcard_constraints:
    experiment="|".join(EXPERIMENTS) or "none",
    job="[A-Za-z0-9_.-]+",


rule compile_experiment:
    output:
        f"{RESULTS}/logs/{{experiment}}_kernels.txt",
    params:
        kernels=lambda w: kernels_of(
            (
                point.settings.case.effects,
                point.settings.choices,
                point.settings.numerics,
            )
            for points in JOBS[w.experiment].values()
            for point in points
        ),
    script:
        "../scripts/compile_kernels.py"


rule close_points:
    input:
        f"{RESULTS}/logs/{{experiment}}_kernels.txt",
    output:
        f"{RESULTS}/{{experiment}}/{{job}}.nc",
    params:
        points=lambda w: engine.packed(JOBS[w.experiment][w.job]),
        quantities=lambda w: list(EXPERIMENTS[w.experiment].quantities),
    script:
        "../scripts/close_points.py"


for NAME, EXPERIMENT in EXPERIMENTS.items():

    rule:
        name:
            f"estimate_{NAME}"
        input:
            f"{RESULTS}/logs/{NAME}_kernels.txt",
        output:
            f"{RESULTS}/tables/{NAME}_estimate.csv",
        priority: 100
        params:
            jobs={job: engine.packed(points) for job, points in JOBS[NAME].items()},
        script:
            "../scripts/estimate_points.py"

    rule:
        name:
            f"tabulate_{NAME}"
        input:
            joints=[f"{RESULTS}/{NAME}/{job}.nc" for job in JOBS[NAME]],
        output:
            joints=f"{RESULTS}/{NAME}.nc",
            tables=[f"{RESULTS}/tables/{table}.csv" for table in DESIGNS[NAME].tables],
        params:
            experiment=NAME,
            parameters=DESIGNS[NAME].parameters,
            code=code_of_experiment(NAME, "tabulate_points"),
        script:
            "../scripts/tabulate_points.py"

    rule:
        name:
            f"draw_{NAME}"
        input:
            tables=[f"{RESULTS}/tables/{table}.csv" for table in DESIGNS[NAME].tables],
        output:
            figures=[
                f"{RESULTS}/figures/{figure}.{format}"
                for figure in DESIGNS[NAME].figures
                for format in ("png", "pdf")
            ],
        params:
            experiment=NAME,
            code=code_of_experiment(NAME, "draw_experiment"),
        script:
            "../scripts/draw_experiment.py"

    rule:
        name:
            NAME
        input:
            f"{RESULTS}/{NAME}.nc",
            f"{RESULTS}/tables/{NAME}_estimate.csv",
            [f"{RESULTS}/tables/{table}.csv" for table in DESIGNS[NAME].tables],
            [
                f"{RESULTS}/figures/{figure}.{format}"
                for figure in DESIGNS[NAME].figures
                for format in ("png", "pdf")
            ],
        message:
            f"The experiment {NAME} is complete: {EXPERIMENT.title}"

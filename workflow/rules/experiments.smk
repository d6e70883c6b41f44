# Experiments: one engine closes points; tables and figures follow. The rules serve the experiments whose
# section the configuration has: `snakemake size --configfile studies/size/size.yaml`.


wildcard_constraints:
    experiment="|".join(EXPERIMENTS) or "none",
    job="[A-Za-z0-9_.-]+",


rule compile_experiment:
    output:
        f"{RESULTS}/logs/{{experiment}}_kernels.txt",
    params:
        kernels=lambda w: DESIGNS[w.experiment].kernels(),
    script:
        "../scripts/compile_kernels.py"


rule close_points:
    input:
        ancient(f"{RESULTS}/logs/{{experiment}}_kernels.txt"),
    output:
        f"{RESULTS}/{{experiment}}/{{job}}.nc",
    params:
        points=lambda w: engine.packed(DESIGNS[w.experiment].jobs[w.job]),
        quantities=lambda w: list(EXPERIMENTS[w.experiment].quantities),
    script:
        "../scripts/close_points.py"


for NAME, EXPERIMENT in EXPERIMENTS.items():

    rule:
        name:
            f"estimate_{NAME}"
        input:
            ancient(f"{RESULTS}/logs/{NAME}_kernels.txt"),
        output:
            f"{RESULTS}/tables/{NAME}_estimate.csv",
        priority: 100
        params:
            samples=lambda w, name=NAME: packed_samples(name),
        script:
            "../scripts/estimate_points.py"

    rule:
        name:
            f"tabulate_{NAME}"
        input:
            joints=[f"{RESULTS}/{NAME}/{job}.nc" for job in DESIGNS[NAME].jobs],
            files=list(DESIGNS[NAME].files.values()),
        output:
            joints=f"{RESULTS}/{NAME}.nc",
            tables=[table_file(table) for table in DESIGNS[NAME].tables],
        params:
            experiment=NAME,
            parameters=DESIGNS[NAME].parameters,
            files=dict(DESIGNS[NAME].files),
            code=code_of_experiment(NAME, "tabulate_points"),
        script:
            "../scripts/tabulate_points.py"

    rule:
        name:
            f"draw_{NAME}"
        input:
            tables=[table_file(table) for table in DESIGNS[NAME].tables],
            files=list(DESIGNS[NAME].files.values()),
        output:
            figures=[
                f"{RESULTS}/figures/{figure}.{format}"
                for figure in DESIGNS[NAME].figures
                for format in ("png", "pdf")
            ],
        params:
            experiment=NAME,
            parameters=DESIGNS[NAME].parameters,
            files=dict(DESIGNS[NAME].files),
            code=code_of_experiment(NAME, "draw_experiment"),
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
        message:
            f"The experiment {NAME} is complete: {EXPERIMENT.title}"

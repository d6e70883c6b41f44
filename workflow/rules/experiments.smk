# Experiments: points are closed by one engine, and put into tables and figures. The rules have work for
# those experiments whose section the configuration has: `snakemake size --configfile config/size.yaml`.


wildcard_constraints:
    experiment="|".join(EXPERIMENTS) or "none",
    job="[A-Za-z0-9_.-]+",


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


for NAME, EXPERIMENT in EXPERIMENTS.items():

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
            code=code_of("estimate_points"),
        message:
            f"Estimate the time of the experiment {NAME}, by a few of its joints"
        script:
            "../scripts/estimate_points.py"

    rule:
        name:
            f"tabulate_{NAME}"
        input:
            joints=[f"{RESULTS}/{NAME}/{job}.nc" for job in DESIGNS[NAME].jobs],
            seals=[closing_seal(NAME, job) for job in DESIGNS[NAME].jobs],
        output:
            joints=f"{RESULTS}/{NAME}.nc",
            tables=[f"{RESULTS}/tables/{table}.csv" for table in DESIGNS[NAME].tables],
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
            made_with=lambda w, name=NAME: closed_with(name),
            code=code_of_experiment(NAME, "tabulate_points"),
        message:
            f"Find {EXPERIMENT.title}"
        script:
            "../scripts/tabulate_points.py"

    rule:
        name:
            f"draw_{NAME}"
        input:
            tables=[f"{RESULTS}/tables/{table}.csv" for table in DESIGNS[NAME].tables],
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
            [f"{RESULTS}/tables/{table}.csv" for table in DESIGNS[NAME].tables],
            [
                f"{RESULTS}/figures/{figure}.{format}"
                for figure in DESIGNS[NAME].figures
                for format in ("png", "pdf")
            ],
            seals_of(f"estimate_{NAME}", f"tabulate_{NAME}", f"draw_{NAME}"),
        message:
            f"The experiment {NAME} is complete: {EXPERIMENT.title}"

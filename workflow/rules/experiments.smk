# Experiments: one job closes the joints of one and makes its tables, and one draws. The rules serve the experiments
# whose section the configuration has: `snakemake size --configfile studies/size/size.yaml`.


wildcard_constraints:
    experiment="|".join(EXPERIMENTS) or "none",


for NAME, EXPERIMENT in EXPERIMENTS.items():
    DESIGN = DESIGNS[NAME]
    FIGURE_FILES = [
        f"{RESULTS}/figures/{figure}.{format}"
        for figure in DESIGN.figures
        for format in ("png", "pdf")
    ]

    rule:
        name:
            f"estimate_{NAME}"
        output:
            f"{RESULTS}/tables/{NAME}_estimate.csv",
        priority: 100
        params:
            experiment=NAME,
            samples=lambda w, design=DESIGN: digest(design.timed()),
        script:
            "../scripts/estimate_points.py"

    rule:
        name:
            f"close_{NAME}"
        input:
            closed=lambda w, name=NAME: closed_apart(*CACHED(name)),
            files=list(DESIGN.files.values()),
        output:
            joints=f"{RESULTS}/{NAME}.nc",
            tables=[table_file(table) for table in DESIGN.tables],
        threads: workflow.cores
        params:
            experiment=NAME,
            joints=lambda w, name=NAME: keys_of(name),
            parameters=digest(DESIGN.parameters),
            code=code_digest(
                str(ROOT / "workflow/scripts/close_experiment.py"), f"studies.{NAME}"
            ),
        script:
            "../scripts/close_experiment.py"

    rule:
        name:
            f"draw_{NAME}"
        input:
            tables=[table_file(table) for table in DESIGN.tables],
            files=list(DESIGN.files.values()),
        output:
            figures=FIGURE_FILES,
        params:
            experiment=NAME,
            parameters=digest(DESIGN.parameters),
            code=code_digest(
                str(ROOT / "workflow/scripts/draw_experiment.py"), f"studies.{NAME}"
            ),
        script:
            "../scripts/draw_experiment.py"

    rule:
        name:
            NAME
        input:
            f"{RESULTS}/{NAME}.nc",
            f"{RESULTS}/tables/{NAME}_estimate.csv",
            [table_file(table) for table in DESIGN.tables],
            FIGURE_FILES,
        message:
            f"The experiment {NAME} is complete: {EXPERIMENT.title}"

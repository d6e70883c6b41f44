# The report of the study, a page, and the evidence for each conclusion of the paper.


rule conclude:
    input:
        claims=f"{RESULTS}/tables/claims.csv",
        # tables of other studies, published or (sensitivity) from a run in this folder
        jrc_range=existing("studies/paper/published/jrc_range/jrc_range_claims.csv"),
        readings=existing("studies/paper/published/conclusions/earlier_readings.csv"),
        choices=existing(*[f"{folder}_conclusions.csv" for folder in SENSITIVITY]),
        margins=existing(*[f"{folder}_margins.csv" for folder in SENSITIVITY]),
    output:
        f"{RESULTS}/tables/conclusions.csv",
    log:
        f"{RESULTS}/logs/conclude.log",
    conda:
        ENVIRONMENT
    params:
        code=code("conclude.py"),
    message:
        "Tabulate the evidence for each conclusion of the paper"
    script:
        "../scripts/conclude.py"


rule conclusions:
    input:
        rules.conclude.output[0],
    message:
        "The judged conclusions are in {input[0]}"


rule write_report:
    input:
        study=f"{RESULTS}/study.nc",
        tables=collect(f"{RESULTS}/tables/{{table}}", table=TABLES),
        assessed=collect(f"{RESULTS}/tables/{{table}}", table=ASSESSED_TABLES),
        figures=collect(
            f"{RESULTS}/figures/{{figure}}.png", figure=FIGURES + FIRST_PANELS
        ),
        # tables of other targets that have been run
        beside=[
            file
            for name in ("assessment", "hardness", "conclusions")
            for file in [f"{RESULTS}/tables/{name}.csv"]
            if os.path.exists(file)
        ],
        paper=PAPER_TABLE_3,
        default="config/default.yaml",
    output:
        f"{RESULTS}/report.html",
    log:
        f"{RESULTS}/logs/write_report.log",
    conda:
        ENVIRONMENT
    params:
        key=KEYS["study"],
        templates=template_digest(),
        code=code("write_report.py"),
    message:
        "Write the study as one page"
    script:
        "../scripts/write_report.py"


rule report:
    input:
        rules.write_report.output[0],
    message:
        "The report is {input[0]}"

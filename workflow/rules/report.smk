# The study as one page to read: `snakemake report`.
from studies.paper.report.page import template_digest

ASSESSED = [f"{RESULTS}/tables/{table}.csv" for table in ("assessment", "hardness")]
CONCLUSIONS = f"{RESULTS}/tables/conclusions.csv"


rule report:
    input:
        f"{RESULTS}/report.html",
    message:
        "The report of {STUDY} is {input[0]}"


rule write_report:
    input:
        study=f"{RESULTS}/study.nc",
        tables=TABLES,
        figures=FIGURES,
        captions=[caption(figure) for figure in FIGURES],
        paper=PAPER,
        default=os.path.relpath(DEFAULT),
        # what `make assess` measured, where it was run
        assessed=[ancient(table) for table in ASSESSED if Path(table).exists()],
        # what `make conclusions` put together
        conclusions=ancient(CONCLUSIONS) if Path(CONCLUSIONS).exists() else [],
    output:
        f"{RESULTS}/report.html",
    params:
        code=[code_of("write_report"), template_digest()],
    script:
        "../scripts/write_report.py"

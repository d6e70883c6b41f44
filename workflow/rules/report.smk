# The study as one page to read: `snakemake report`.
from jointclosure.config.files import MEASURED as MEASURED_SETTINGS
from jointclosure.report.page import template_digest

ACCURACY_TABLE = "results/accuracy/tables/accuracy_cost.csv"
ACCURACY_SEALS = seals_of("tabulate_accuracy", study="results/accuracy")
ACCURACY_MEASURED = all(
    Path(path).exists() for path in [ACCURACY_TABLE, *ACCURACY_SEALS]
)
CONCLUSIONS = [f"{RESULTS}/tables/conclusions.csv", *seals_of("conclude")]
CONCLUDED = all(Path(path).exists() for path in CONCLUSIONS)


rule report:
    input:
        f"{RESULTS}/report.html",
        seals_of("write_report"),
    message:
        "The report of {STUDY} is {input[0]}"


rule write_report:
    input:
        study=f"{RESULTS}/study.nc",
        tables=expand(f"{RESULTS}/tables/{{table}}", table=TABLES),
        figures=expand(f"{RESULTS}/figures/{{figure}}.png", figure=FIGURES),
        captions=[CAPTIONS / f"{figure}.rst" for figure in FIGURES],
        paper=PAPER_TABLE_3,
        default=DEFAULT,
        presets=MEASURED_SETTINGS,
        # what `make accuracy` measured, where it was run
        accuracy=ancient(ACCURACY_TABLE) if ACCURACY_MEASURED else [],
        # what `make conclusions` put together
        conclusions=ancient(CONCLUSIONS[0]) if CONCLUDED else [],
        seals=STUDY_SEALS
        + (ACCURACY_SEALS if ACCURACY_MEASURED else [])
        + (CONCLUSIONS[1:] if CONCLUDED else []),
    output:
        f"{RESULTS}/report.html",
        seal=f"{RESULTS}/seals/write_report.json",
    log:
        f"{RESULTS}/logs/write_report.log",
    benchmark:
        f"{RESULTS}/benchmarks/write_report.tsv"
    conda:
        ENVIRONMENT
    params:
        made_with=STUDY_WITH,
        code=[code_of("write_report"), template_digest()],
    message:
        "Write the report"
    script:
        "../scripts/write_report.py"

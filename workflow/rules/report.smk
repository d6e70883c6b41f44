# The study as one page to read: `snakemake report`.
from jointclosure.config.files import MEASURED as MEASURED_SETTINGS
from jointclosure.report.page import template_digest

ACCURACY_TABLE = "results/accuracy/tables/accuracy_cost.csv"


rule report:
    input:
        f"{RESULTS}/report.html",
    message:
        "The report of {STUDY} is {input}"


rule write_report:
    input:
        study=f"{RESULTS}/study.nc",
        closures=f"{RESULTS}/tables/max_closure.csv",
        # those that a study has not are left out
        intervals=(
            f"{RESULTS}/tables/table_3_indifference.csv"
            if "table_3_indifference.csv" in TABLES
            else []
        ),
        claims=f"{RESULTS}/tables/claims.csv" if "claims.csv" in TABLES else [],
        predictive=f"{RESULTS}/tables/table_3_predictive.csv",
        joint=f"{RESULTS}/tables/table_3_joint_tests.csv",
        elasticities=f"{RESULTS}/tables/elasticities.csv",
        measured=(
            f"{RESULTS}/tables/measured_fit.csv"
            if "measured_fit.csv" in TABLES
            else []
        ),
        figures=expand(f"{RESULTS}/figures/{{figure}}.png", figure=FIGURES),
        captions=expand(
            "{folder}/workflow/report/{figure}.rst", folder=ROOT, figure=FIGURES
        ),
        paper=PAPER_TABLE_3,
        default=DEFAULT,
        presets=MEASURED_SETTINGS,
        # what `make accuracy` measured, where it was run
        accuracy=ancient(ACCURACY_TABLE) if Path(ACCURACY_TABLE).exists() else [],
    output:
        f"{RESULTS}/report.html",
    log:
        f"{RESULTS}/logs/write_report.log",
    benchmark:
        f"{RESULTS}/benchmarks/write_report.tsv"
    conda:
        ENVIRONMENT
    params:
        configuration=config,
        benchmarks=f"{RESULTS}/benchmarks",
        code=[code_of("write_report"), template_digest()],
    message:
        "Write the report"
    script:
        "../scripts/write_report.py"

# Sensitivity of the closure of rough rock joints: surfaces of every case, their closure over load
# cycles, one dataset of all, correlations, indifference intervals, tables, figures and a page.
# `snakemake --configfile config/mine.yaml` runs another study than the paper's.
from snakemake.utils import min_version

min_version("9.27")


configfile: "config/default.yaml"


report: "workflow/report/study.rst"


include: "workflow/rules/common.smk"
include: "workflow/rules/run.smk"
include: "workflow/rules/surfaces.smk"
include: "workflow/rules/closures.smk"
include: "workflow/rules/statistics.smk"
include: "workflow/rules/tables.smk"
include: "workflow/rules/figures.smk"
include: "workflow/rules/assessment.smk"
include: "workflow/rules/report.smk"
include: "workflow/rules/accuracy.smk"
include: "workflow/rules/experiments.smk"
include: "workflow/rules/hard_cases.smk"


rule all:
    default_target: True
    input:
        collect(f"{RESULTS}/walls/{{rock}}.nc", rock=SCANNED),
        collect(f"{RESULTS}/{{dataset}}.nc", dataset=DATASETS),
        collect(f"{RESULTS}/tables/{{table}}", table=TABLES),
        collect(
            f"{RESULTS}/figures/{{figure}}.{{form}}",
            figure=FIGURES,
            form=["png", "pdf"],
        ),
        f"{RESULTS}/logs/checks_passed.txt",
    message:
        "The study {STUDY.study.name} is complete"

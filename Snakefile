# Entry of the pipeline: configuration, rules, targets. See README.md for the commands.
from snakemake.utils import min_version

from jointclosure.config.files import DEFAULT

min_version("9.27")


configfile: DEFAULT


include: "workflow/rules/setting.smk"
include: "workflow/rules/simulate.smk"
include: "workflow/rules/walls.smk"
include: "workflow/rules/analyse.smk"
include: "workflow/rules/present.smk"
include: "workflow/rules/report.smk"
include: "workflow/rules/hard_cases.smk"
include: "workflow/rules/accuracy.smk"
include: "workflow/rules/effects.smk"
include: "workflow/rules/readings.smk"
include: "workflow/rules/numerics.smk"


onstart:
    if NUMERICS_SAID:
        logger.info(NUMERICS_SAID)


rule all:
    default_target: True
    input:
        f"{RESULTS}/study.nc",
        expand(f"{RESULTS}/tables/{{table}}", table=TABLES),
        expand(
            f"{RESULTS}/figures/{{figure}}.{{format}}",
            figure=FIGURES,
            format=["png", "pdf"],
        ),
    message:
        "The study {STUDY} is complete"

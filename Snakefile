# Entry of the pipeline: configuration, rules, targets. See README.md for the commands.
from snakemake.utils import min_version

min_version("9.27")


configfile: "config/default.yaml"


include: "workflow/rules/setting.smk"
include: "workflow/rules/simulate.smk"
include: "workflow/rules/analyse.smk"
include: "workflow/rules/present.smk"


rule all:
    default_target: True
    message:
        "The study {STUDY} is complete"
    input:
        f"{RESULTS}/study.nc",
        expand(RESULTS + "/tables/{table}", table=TABLES),
        expand(
            RESULTS + "/figures/{figure}.{format}", figure=FIGURES, format=["png", "pdf"]
        ),

# Entry of the pipeline: configuration, rules, targets. See README.md for the commands.
import sys

from snakemake.utils import min_version

from jointclosure.config.files import DEFAULT
from jointclosure.storage.seals import unmet_seals

min_version("9.27")


configfile: DEFAULT


include: "workflow/rules/setting.smk"
include: "workflow/rules/simulate.smk"
include: "workflow/rules/walls.smk"
include: "workflow/rules/analyse.smk"
include: "workflow/rules/present.smk"
include: "workflow/rules/surrogate.smk"
include: "workflow/rules/jrc_range.smk"
include: "workflow/rules/conclusions_setting.smk"
include: "workflow/rules/conclusions.smk"
include: "workflow/rules/report.smk"
include: "workflow/rules/hard_cases.smk"
include: "workflow/rules/experiments_setting.smk"
include: "workflow/rules/experiments.smk"
include: "workflow/rules/accuracy.smk"
include: "workflow/rules/effects.smk"


DRY_RUN = bool({"-n", "--dry-run", "--dryrun"} & set(sys.argv))
# a file that is not the one that its seal, or this configuration, says is made again
if workflow.is_main_process:
    for folder, made_with in (
        (RESULTS, STUDY_WITH | CHOSEN_WITH | WALLS_WITH),
        (RESULTS, VALIDATED_WITH),
        *((RESULTS, closed_with(name, closed_before(name))) for name in EXPERIMENTS),
        (HARD_RESULTS, HARD_WITH),
    ):
        for seal, reason in list(unmet_seals(folder, made_with)):
            logger.warning(f"jointclosure: {reason.partition(': delete')[0]}")
            if not DRY_RUN:
                seal.unlink(missing_ok=True)


onstart:
    if NUMERICS_SAID:
        logger.info(f"jointclosure: {NUMERICS_SAID}")


rule all:
    default_target: True
    input:
        f"{RESULTS}/study.nc",
        f"{RESULTS}/logs/checks_passed.txt",
        STUDY_SEALS,
        expand(f"{RESULTS}/tables/{{table}}", table=TABLES),
        expand(
            f"{RESULTS}/figures/{{figure}}.{{format}}",
            figure=FIGURES,
            format=["png", "pdf"],
        ),
    message:
        "The study {STUDY} is complete"

# Entry of the pipeline: configuration, rules, targets. See README.md for the commands.
import os
import sys

from snakemake.utils import min_version

from studies.frame.config.files import DEFAULT
from studies.frame.jobs.folder import enter_folder
from studies.frame.jobs.rules import complete
from studies.frame.jobs.server import JobServer

min_version("9.27")


configfile: DEFAULT


include: "workflow/rules/setting.smk"
include: "workflow/rules/simulate.smk"
include: "workflow/rules/walls.smk"
include: "workflow/rules/products.smk"
include: "workflow/rules/report.smk"
include: "workflow/rules/hard_cases.smk"
include: "workflow/rules/experiments_setting.smk"
include: "workflow/rules/experiments.smk"
include: "workflow/rules/accuracy.smk"
include: "workflow/rules/effects.smk"


onstart:
    if NUMERICS_REMARK:
        logger.info(f"jointclosure: {NUMERICS_REMARK}")
    if workflow.local_exec:  # on a cluster each job starts on its node
        # Snakemake names it to bash without quotes, whatever the name of this folder
        sys.executable = os.path.relpath(sys.executable)
        # a limit of starts per second makes each job that has ended wake Snakemake every second
        workflow.scheduler.job_rate_limiter = None
        try:
            server = JobServer(
                ROOT / "workflow/scripts", f"{RESULTS}/logs/*kernels.txt"
            )
            shell.prefix(server.prefix())
        except OSError as error:
            logger.info(f"jobs start without a server: {error}")


rule all:
    default_target: True
    input:
        f"{RESULTS}/study.nc",
        COMPLETE,
    message:
        "The study {STUDY} is complete"


# files of surfaces and closures bear their settings themselves, and the kernels' are notes
SEALED = complete(
    workflow.rules,
    environment="../envs/jointclosure.yaml",
    without_seal={
        "make_surfaces",
        "cut_surfaces",
        "close_surfaces",
        "require_checks",
        *(rule.name for rule in workflow.rules if rule.name.startswith("compile_")),
    },
)
# a file that is not the one that its seal, or this configuration, says is made again
LOOKS = {
    "-n",
    "--dry-run",
    "--dryrun",
    "-l",
    "--list-rules",
    "--lint",
    "--unlock",
    "--summary",
}
if workflow.is_main_process:
    works = not LOOKS & set(sys.argv)
    if works:
        enter_folder()  # a run at work in this folder keeps its seals
    SEALED.withdraw_unmet(logger.warning, remove=works)

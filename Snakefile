# Entry of the pipeline: configuration, rules, targets. See README.md for the commands.
import os
import sys

from snakemake.utils import min_version

from studies.frame.files import DEFAULT
from studies.frame.folder import enter_folder
from studies.frame.jobs import ENGINE
from studies.frame.rules import complete, withdraw_unmet

min_version("9.27")


configfile: DEFAULT


include: "workflow/rules/setting.smk"
include: "workflow/rules/experiments_setting.smk"
include: "workflow/rules/joints.smk"
include: "workflow/rules/walls.smk"
include: "workflow/rules/products.smk"
include: "workflow/rules/report.smk"
include: "workflow/rules/hard_cases.smk"
include: "workflow/rules/experiments.smk"


onstart:
    if workflow.local_exec:  # on a cluster each job starts on its node
        # Snakemake names it to bash without quotes, whatever the name of this folder
        sys.executable = os.path.relpath(sys.executable)
        # jobs are children of this process, and end with it
        os.environ[ENGINE] = str(os.getpid())
        shell.prefix("set -euo pipefail; exec ")


rule all:
    default_target: True
    input:
        COMPLETE,
        WALLS,
        rules.close_study.output,
        rules.close_pool.output if "pool" in ENSEMBLES else [],
    message:
        "The study {STUDY} is complete"


complete(workflow.rules, environment="../envs/jointclosure.yaml")
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
        enter_folder()  # a run at work in this folder keeps its files
    withdraw_unmet(workflow.rules, logger.warning, remove=works)

# Entry of the pipeline: a rule for each step of `studies.pipeline`, and targets. See README.md for the commands.
import os
import sys

from snakemake.utils import min_version

from studies.frame.configuration import configured
from studies.frame.yaml_files import DEFAULT, read_plain
from studies.frame.lock import enter_folder
from studies.frame.seals import ENGINE, study_of, withdraw_unmet
from studies.pipeline import Pipeline

min_version("9.27")


configfile: DEFAULT


for file in workflow.configfiles:
    read_plain(file)
STUDY = configured(config)
config.update(STUDY.stated)
PIPELINE = Pipeline(
    STUDY, apart=not workflow.local_exec, check=workflow.is_main_process
)
RESULTS = PIPELINE.folder
KINDS = [*PIPELINE.ensembles, *PIPELINE.designs]


wildcard_constraints:
    kind="|".join(["effects_of", *KINDS]),
    kernels="[0-9a-f]{8}",


onstart:
    if workflow.local_exec:  # on a cluster each job starts on its node
        # Snakemake names it to bash without quotes, whatever the name of this folder
        sys.executable = os.path.relpath(sys.executable)
        # jobs are children of this process, and end with it
        os.environ[ENGINE] = str(os.getpid())
        shell.prefix("set -euo pipefail; exec ")


for NAME, (FILES, MESSAGE) in PIPELINE.targets.items():

    rule:
        name:
            NAME
        default_target: NAME == "all"
        input:
            FILES,
        message:
            MESSAGE


for NAME, STEP in PIPELINE.steps.items():
    FOLDER = study_of(STEP.files[0])

    rule:
        name:
            NAME
        input:
            **{
                name: ancient(path) if path and name in STEP.untimed else path
                for name, path in STEP.inputs.items()
            },
        output:
            STEP.files,
        log:
            f"{FOLDER}/logs/{NAME}.log",
            benchmark=f"{FOLDER}/benchmarks/{NAME}.tsv",
        priority: STEP.priority
        group:
            STEP.group
        conda:
            "workflow/envs/jointclosure.yaml"
        threads: workflow.cores if STEP.all_cores else 1
        params:
            **STEP.params(lambda wildcards, step=STEP: step.depends()),
        message:
            STEP.title
        script:
            "workflow/scripts/make.py"


# on a cluster each file of the cache is a job of its own, before the job that reads it
rule compile_kernels:
    output:
        f"{RESULTS}/logs/{{kind}}_kernels_{{kernels}}.txt",
    log:
        f"{RESULTS}/logs/compile_kernels/{{kind}}_{{kernels}}.log",
        benchmark=f"{RESULTS}/benchmarks/compile_kernels/{{kind}}_{{kernels}}.tsv",
    conda:
        "workflow/envs/jointclosure.yaml"
    params:
        make="jointclosure.joint.warmup:compile_all",
        settings=lambda w: {"kernels": PIPELINE.kernels(w.kind)},
    message:
        "Compile all necessary kernels before parallel jobs start ({wildcards.kind})"
    script:
        "workflow/scripts/make.py"


rule close_block:
    input:
        lambda w: (
            PIPELINE.walls if w.kind in ("effects_of", *PIPELINE.ensembles) else []
        ),
        lambda w: (
            PIPELINE.closed_apart("effects_of") if w.kind in PIPELINE.ensembles else []
        ),
        kernels=lambda w: ancient(PIPELINE.kernels_file(w.kind)),
    output:
        f"{RESULTS}/{{kind}}/{{block}}.nc",
    log:
        f"{RESULTS}/logs/close_block/{{kind}}/{{block}}.log",
        benchmark=f"{RESULTS}/benchmarks/close_block/{{kind}}/{{block}}.tsv",
    group:
        "closures"
    conda:
        "workflow/envs/jointclosure.yaml"
    params:
        make="studies.frame.experiments:close_apart",
        settings=lambda w: {"kind": w.kind, "block": w.block},
        key=lambda w: PIPELINE.cached(w.kind)[f"{w.kind}/{w.block}"].key,
    message:
        "Close the joints of one file of the cache ({wildcards.kind}, {wildcards.block})"
    script:
        "workflow/scripts/make.py"


# a file that is not the one that its seal, or this configuration, says is made again
LOOKS = {*"-n --dry-run --dryrun -l --list-rules --lint --unlock --summary".split()}
if workflow.is_main_process:
    works = not LOOKS & set(sys.argv)
    if works:
        enter_folder()  # a run at work in this folder keeps its files
    withdraw_unmet(PIPELINE.steps.values(), logger.warning, remove=works)

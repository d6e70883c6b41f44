# Shared by the rules of experiments: the experiments of the configuration, and their jobs. No rules here.
# Every job reads this file anew: slow checks run in the main process only, and slow values are made on demand.
from jointclosure.engine import points as engine
from studies.frame.experiments import experiments_in

EXPERIMENTS = experiments_in(config)
for experiment in EXPERIMENTS.values():
    if workflow.is_main_process:
        experiment.check(CONFIGURED)
DESIGNS = {
    name: experiment.design(CONFIGURED) for name, experiment in EXPERIMENTS.items()
}


def code_of_experiment(name, script):
    """Digest of a script and of the module of an experiment, which the script imports by its name."""
    return code_digest(
        str(ROOT / f"workflow/scripts/{script}.py"), f"studies.{name}"
    )


def table_file(table):
    """File of a table by its name; that of a text has its ending."""
    return f"{RESULTS}/tables/{table}{'' if '.' in table else '.csv'}"


def packed_samples(experiment):
    """Points by which the time of an experiment is estimated, as plain data."""
    return {
        name: [[engine.packed(sample.points), sample.joints] for sample in samples]
        for name, samples in DESIGNS[experiment].timed().items()
    }

# Shared by the rules of experiments: the experiments of the configuration, and their jobs. No rules here.
# Every job reads this file anew: slow checks run in the main process only, and slow values are made on demand.
from studies.frame.experiments import cached, experiments_in

EXPERIMENTS = experiments_in(config)
for experiment in EXPERIMENTS.values():
    if workflow.is_main_process:
        experiment.check(CONFIGURED)
DESIGNS = {
    name: experiment.design(CONFIGURED) for name, experiment in EXPERIMENTS.items()
}


def table_file(table):
    """File of a table by its name; that of a text has its ending."""
    return f"{RESULTS}/tables/{table}{'' if '.' in table else '.csv'}"

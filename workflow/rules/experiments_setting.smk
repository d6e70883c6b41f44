# What the rules of experiments share: the experiments of the configuration, and their jobs. No rules here.
from jointclosure.ensemble import points as engine
from jointclosure.experiments import experiments_in

EXPERIMENTS = experiments_in(config)
DESIGNS = {name: each.design(CONFIGURED) for name, each in EXPERIMENTS.items()}
JOBS = {name: design.jobs for name, design in DESIGNS.items()}


def code_of_experiment(name, script):
    """Digest of a script and of the module of an experiment, which the script imports by its name."""
    return code_digest(
        str(ROOT / f"workflow/scripts/{script}.py"), f"experiments.{name}"
    )

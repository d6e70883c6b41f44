# What the rules of experiments share: the experiments of the configuration, their jobs, and seals. No rules here.
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


def closing(experiment, job):
    """Parameters of the job that closes some points."""
    return {
        "points": engine.packed(JOBS[experiment][job]),
        "quantities": list(EXPERIMENTS[experiment].quantities),
        "code": code_of("close_points"),
    }


CLOSED_WITH = {
    name: {
        seals_of(f"close_{name}/{job}")[0]: settings_digest(closing(name, job))
        for job in jobs
    }
    for name, jobs in JOBS.items()
}

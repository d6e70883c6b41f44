# What the rules of experiments share: the experiments of the configuration, their jobs, and seals. No rules here.
# Every job reads this anew: what takes long is checked or made in the main process only, or when a rule asks for it.
from functools import cache

from jointclosure.ensemble import points as engine
from jointclosure.experiments import experiments_in

EXPERIMENTS = experiments_in(config)
for each in EXPERIMENTS.values():
    if workflow.is_main_process:
        each.check(CONFIGURED)
DESIGNS = {name: each.design(CONFIGURED) for name, each in EXPERIMENTS.items()}
CODE_OF_CLOSING = code_of("close_points")


def code_of_experiment(name, script):
    """Digest of a script and of the module of an experiment, which the script imports by its name."""
    return code_digest(
        str(ROOT / f"workflow/scripts/{script}.py"), f"experiments.{name}"
    )


@cache
def closing(experiment, job):
    """Parameters of the job that closes some points."""
    return {
        "points": engine.packed(DESIGNS[experiment].jobs[job]),
        "quantities": list(EXPERIMENTS[experiment].quantities),
        "code": CODE_OF_CLOSING,
    }


def closing_seal(experiment, job):
    """The seal of a job that closes some points."""
    return seals_of(f"close_{experiment}/{job}")[0]


@cache
def closed_with(experiment):
    """Digests of settings that seals of the jobs of an experiment must have."""
    return {
        closing_seal(experiment, job): settings_digest(closing(experiment, job))
        for job in DESIGNS[experiment].jobs
    }


def packed_samples(experiment):
    """Points by which the time of an experiment is estimated, as plain data."""
    return {
        name: [[engine.packed(sample.points), sample.joints] for sample in samples]
        for name, samples in DESIGNS[experiment].timed().items()
    }

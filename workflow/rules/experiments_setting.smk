# Shared by the rules of experiments: the experiments of the configuration, their jobs and rounds. No rules here.
# Every job reads this file anew: slow checks run in the main process only, and slow values are made on demand.
from jointclosure.ensemble import points as engine
from jointclosure.experiments import experiments_in

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
        str(ROOT / f"workflow/scripts/{script}.py"), f"experiments.{name}"
    )


def table_file(table):
    """File of a table by its name; that of a text has its ending."""
    return f"{RESULTS}/tables/{table}{'' if '.' in table else '.csv'}"


def round_names(experiment):
    """Rounds of an experiment; most have none."""
    rounds = DESIGNS[experiment].rounds
    return rounds.names if rounds else ()


def ranking_job(experiment, number):
    return f"{experiment}_round_{round_names(experiment)[number]}"


def rankings_before(experiment, number):
    """Ranking of the round before one, none before the first."""
    return [ranking_job(experiment, number - 1)] if number else []


def entrants_of(experiment, number):
    """Names of the entrants of a round, once the round before is ranked."""
    before = None
    if number:
        last = round_names(experiment)[number - 1]
        ranked = checkpoints.rank_round.get(experiment=experiment, round=last)
        before = read_csv(ranked.output[0])
    return DESIGNS[experiment].rounds.entrants(number, before)


def jobs_of_round(experiment, number):
    """Jobs that a round needs."""
    entrants = entrants_of(experiment, number)
    return DESIGNS[experiment].rounds.jobs(number, entrants)


def jobs_of(experiment):
    """Jobs of all rounds by name; without rounds all jobs, in their order."""
    numbers = range(len(round_names(experiment)))
    jobs = {job for number in numbers for job in jobs_of_round(experiment, number)}
    return sorted(jobs) if numbers else list(DESIGNS[experiment].jobs)


def joints_of(experiment, jobs):
    """Files of the joints of jobs."""
    return [f"{RESULTS}/{experiment}/{job}.nc" for job in jobs]


def number_of(w):
    """Number of a round."""
    return round_names(w.experiment).index(w.round)


def packed_samples(experiment):
    """Points by which the time of an experiment is estimated, as plain data."""
    return {
        name: [[engine.packed(sample.points), sample.joints] for sample in samples]
        for name, samples in DESIGNS[experiment].timed().items()
    }

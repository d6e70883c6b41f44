"""Estimate the time of an experiment from a few of its joints."""

import math

from jointclosure.engine.ensembles import estimated_time
from jointclosure.storage.files import write_csv
from studies.frame.experiments import checked, experiment_named
from studies.frame.jobs import compile_all, job

if __name__ == "__main__":
    with job(snakemake) as logbook:
        design = experiment_named(snakemake.params.experiment).design(checked(snakemake.config))
        compile_all(design.kernels(), logbook)
        table = estimated_time(design.timed(), logbook)
        write_csv(table, snakemake.output[0])
        minutes, error = table.seconds.sum() / 60, math.hypot(*table.error) / 60
        known = f" ± {error:.0f}" if math.isfinite(error) else ""
        joints = f"{table.joints.sum()} joints will take"
        logbook.show(f"{joints} about {minutes:.2g}{known} minutes on one core")

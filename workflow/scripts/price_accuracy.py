"""Measure the time of a joint of each rock with the study's numerics and with the finest ones."""

import pandas as pd

from jointclosure.storage.files import write_csv
from jointclosure.storage.logs import logging_to
from studies.frame.settings import walls_in
from studies.frame.simulation import close_joints

if __name__ == "__main__":
    with logging_to(snakemake.log[0]) as log:
        rows = []
        for ensemble, points in snakemake.params.points.items():
            for point, file in zip(points, snakemake.input.surfaces, strict=True):
                rock = point.settings.case.rock
                walls = list(walls_in([file], point.settings))
                close_joints(point, walls, ())  # loads the kernels before a joint is timed
                closed = close_joints(point, walls, (), report=log)
                seconds = float(closed.timing_simulation.mean())
                row = {"ensemble": ensemble, "rock": rock}
                rows.append(row | {"cases": snakemake.params.cases[rock], "seconds": seconds})
        write_csv(pd.DataFrame(rows), snakemake.output[0])

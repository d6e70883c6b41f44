"""Measure what a joint of each rock takes by the study's numerics and by the finest ones."""

from pathlib import Path

import pandas as pd

from jointclosure.storage.files import write_csv
from studies.frame.closing import Ensemble
from studies.frame.configuration import resolved
from studies.frame.jobs import compile_all, job

if __name__ == "__main__":
    with job(snakemake) as logbook:
        rows = []
        for name in ("cases", "finest"):
            ensemble = Ensemble(resolved(snakemake.config), name)
            compile_all(ensemble.kernels(), logbook)
            for first in ensemble.firsts(Path(snakemake.output[0]).parents[1]):
                rock = first.settings[0].case.rock
                cases = sum(case.rock == rock for case in ensemble.cases.values())
                for _ in range(2):  # the first loads the kernels
                    closed = first.make(*first.settings, **first.options, report=logbook)
                seconds = float(closed.timing_simulation.mean())
                rows.append({"ensemble": name, "rock": rock, "cases": cases, "seconds": seconds})
        write_csv(pd.DataFrame(rows), snakemake.output[0])

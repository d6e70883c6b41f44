"""Time of a study's joints by its numerics and by the finest, from which an accuracy is planned."""

from pathlib import Path

import pandas as pd

from jointclosure.joint.warmup import compile_all
from jointclosure.storage.logs import Logbook
from studies.frame.closing import Ensemble
from studies.frame.configuration import resolved


def price_accuracy(config: dict, folder: Path, log: Logbook) -> pd.DataFrame:
    """Measure what a joint of each rock takes by the study's numerics and by the finest ones."""
    rows = []
    for name in ("cases", "finest"):
        ensemble = Ensemble(resolved(config), name, folder)
        compile_all(ensemble.kernels(), log)
        for first in ensemble.firsts():
            rock = first.settings[0].case.rock
            cases = sum(case.rock == rock for case in ensemble.cases.values())
            closed = first.make(*first.settings, **first.options, report=log)
            seconds = float(closed.timing_simulation.mean())
            rows.append({"ensemble": name, "rock": rock, "cases": cases, "seconds": seconds})
    return pd.DataFrame(rows)

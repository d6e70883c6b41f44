"""What a study of readings takes at most, from one joint in every reading and rock."""

from collections.abc import Mapping

import numpy as np
import pandas as pd

from jointclosure.experiments.readings.design import AS_CONFIGURED, PAIRS, SINGLES, Design


def costs(
    design: Design,
    cases: int,
    of_rocks: Mapping[str, float],
    of_readings: Mapping[str, float],
) -> pd.DataFrame:
    """Simulations and time of each round, if as many readings enter as may.

    Parameters
    ----------
    design : Design
    cases : int
        Of a rock.
    of_rocks : mapping
        Seconds of a simulation as configured, by rock.
    of_readings : mapping
        Seconds of a simulation of the first round's first rock, by run. A reading takes in
        other rocks as much longer as it does there, and a pair the mean of all.

    Returns
    -------
    DataFrame
        Columns round, readings, simulations, core_minutes. Surfaces that an earlier round
        closed are not counted again.
    """
    relative = {name: time / of_readings[AS_CONFIGURED] for name, time in of_readings.items()}
    mean = float(np.mean(list(relative.values())))
    closed: dict[str, int] = dict.fromkeys(design.rocks, 0)
    reference = cases * design.reference_realizations
    rows = [
        {
            "round": "as configured",
            "readings": 1,
            "simulations": reference * len(design.rocks),
            "core_minutes": reference * sum(of_rocks.values()) / 60.0,
        }
    ]
    for each in design.rounds:
        if each.candidates == SINGLES:
            readings = len(relative) - 1
            times = sum(relative.values()) - 1.0
        else:
            kept = min(each.most, len(design.singles) - 1)
            readings = kept * (kept - 1) // 2 if each.candidates == PAIRS else kept
            times = readings * mean
        simulations, seconds = 0, 0.0
        for rock in each.rocks:
            new = each.realizations - (0 if each.candidates == PAIRS else closed[rock])
            simulations += readings * cases * max(new, 0)
            seconds += times * cases * max(new, 0) * of_rocks[rock]
            closed[rock] = max(closed[rock], each.realizations)
        rows.append(
            {
                "round": each.name,
                "readings": readings,
                "simulations": simulations,
                "core_minutes": seconds / 60.0,
            }
        )
    return pd.DataFrame(rows)

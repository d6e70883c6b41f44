"""What studies of a joint's closure, residual closure and stiffness read of each cycle."""

import numpy as np
import xarray as xr

from jointclosure.engineering.stiffness import secant_stiffness
from jointclosure.ensemble.closing import close_walls
from jointclosure.ensemble.settings import Conditions
from jointclosure.history import GROSS, NET
from jointclosure.protocol import FAILURE


def cycle_responses(
    walls: tuple[np.ndarray, np.ndarray], conditions: Conditions
) -> tuple[int, dict[str, np.ndarray]]:
    """Close two walls (y, x) [m] to one maximum stress: the status, and `responses_of` its cycles.

    All is NaN where the simulation failed.
    """
    closed = close_walls(*walls, conditions)
    status, answer = int(closed.status), responses_of(closed, conditions)
    if status >= FAILURE:
        answer = {name: np.full(values.shape, np.nan) for name, values in answer.items()}
    return status, answer


def responses_of(closed: xr.Dataset, conditions: Conditions) -> dict[str, np.ndarray]:
    """What is read of each cycle of a joint that was closed to one maximum stress.

    Returns
    -------
    dict of array (cycles,)
        ``closure``, ``closure_net`` of bulk indentation, ``closure_seated``, ``residual`` closure
        and ``closure_above_half``, all in m; ``stiffness`` of loading from half of the maximum
        stress to where it begins to land on all of it (`secant_stiffness`), and ``stiffness_net``
        of bulk indentation [Pa/m]. ``closure_above_half`` is the closure over all of that half at
        the former. Stiffness is NaN where landing begins below half. Where breakage jumps over the
        maximum stress, the last state below it stands for it.
    """
    half = 0.5 * float(np.max(conditions.max_normal_stress))
    closure = closed.max_closure.values
    reached = closed.normal_stress.groupby(closed.cycle).max().values

    def chords(of: str) -> np.ndarray:
        return np.array(
            [secant_stiffness(closed, i, half, top, of) for i, top in enumerate(reached, start=1)]
        )

    stiffness = chords(GROSS)
    return {
        "closure": closure,
        "closure_net": closure - closed.max_bulk_indentation.values,
        "closure_seated": closed.max_closure_seated.values,
        "residual": closed.residual_closure.values,
        "closure_above_half": (reached - half) / stiffness,
        "stiffness": stiffness,
        "stiffness_net": chords(NET),
    }

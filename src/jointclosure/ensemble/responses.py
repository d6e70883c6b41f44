"""What studies of a joint's closure, residual closure and stiffness read of each cycle."""

import numpy as np

from jointclosure.engineering.stiffness import secant_stiffness
from jointclosure.ensemble.closing import close_walls
from jointclosure.ensemble.settings import Conditions
from jointclosure.protocol import FAILURE


def cycle_responses(
    walls: tuple[np.ndarray, np.ndarray], conditions: Conditions
) -> tuple[int, dict[str, np.ndarray]]:
    """Close two walls (y, x) [m] to one maximum stress, and read every cycle.

    Returns
    -------
    status : int
    responses : dict of array (cycles,)
        ``closure``, ``closure_net`` of bulk indentation, ``closure_seated``, ``residual`` closure
        and ``closure_above_half``, all in m; ``stiffness`` of loading from half of the maximum
        stress to where it begins to land on all of it (`secant_stiffness`) [Pa/m]; the former is
        the closure over that half at this stiffness. NaN where the simulation failed, and of
        stiffness where landing begins below half. Where breakage jumps over the maximum stress, the
        last state below it stands for it.
    """
    half = 0.5 * float(np.max(conditions.max_normal_stress))
    closed = close_walls(*walls, conditions)
    status, closure = int(closed.status), closed.max_closure.values
    residual = closed.residual_closure.values
    reached = closed.normal_stress.groupby(closed.cycle).max().values
    stiffness = np.array(
        [secant_stiffness(closed, cycle, half, top) for cycle, top in enumerate(reached, start=1)]
    )
    answer = {
        "closure": closure,
        "closure_net": closure - closed.max_bulk_indentation.values,
        "closure_seated": closed.max_closure_seated.values,
        "residual": residual,
        "closure_above_half": (reached - half) / stiffness,
        "stiffness": stiffness,
    }
    if status >= FAILURE:
        answer = {name: np.full(closure.shape, np.nan) for name in answer}
    return status, answer

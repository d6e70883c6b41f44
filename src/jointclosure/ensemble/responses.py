"""What studies of a joint's closure, residual closure and stiffness read of each cycle."""

import numpy as np

from jointclosure.ensemble.closing import close_pair
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
        and ``closure_above_half`` (of loading, from half of the maximum stress to all of it), all
        in m; ``stiffness`` over that part [Pa/m]. NaN where the simulation failed.
    """
    half = 0.5 * float(np.max(conditions.max_normal_stress))
    row = close_pair(*walls, np.array([half]), conditions)
    status, closure = int(row["status"][1]), row["max_closure"][1]
    above = closure - row["closure"][1][:, 0, 0]
    answer = {
        "closure": closure,
        "closure_net": row["max_closure_net"][1],
        "closure_seated": row["max_closure_seated"][1],
        "residual": row["residual_closure"][1],
        "closure_above_half": above,
        "stiffness": half / above,
    }
    if status >= FAILURE:
        answer = {name: np.full(closure.shape, np.nan) for name in answer}
    return status, answer

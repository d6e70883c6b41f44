"""What studies of a joint's closure, residual closure and stiffness read of each cycle."""

import numpy as np

from jointclosure.engineering.stiffness import closures_at
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
        and ``closure_above_half`` (of loading, from half of the maximum stress to all of it), all
        in m; ``stiffness`` over that part [Pa/m]. NaN where the simulation failed. Where breakage
        jumps over the maximum stress, both are to the last state below it.
    """
    half = 0.5 * float(np.max(conditions.max_normal_stress))
    closed = close_walls(*walls, conditions)
    status, closure = int(closed.status), closed.max_closure.values
    residual = closed.residual_closure.values
    # maxima count from where their cycle began, curves and residual closures from first touch
    begun = np.concatenate([[0.0], residual[:-1]])
    above = begun + closure - closures_at(closed, np.array([half]))[:, 0, 0]
    reached = closed.normal_stress.groupby(closed.cycle).max().values
    answer = {
        "closure": closure,
        "closure_net": closure - closed.max_bulk_indentation.values,
        "closure_seated": closed.max_closure_seated.values,
        "residual": residual,
        "closure_above_half": above,
        "stiffness": (reached - half) / above,
    }
    if status >= FAILURE:
        answer = {name: np.full(closure.shape, np.nan) for name in answer}
    return status, answer

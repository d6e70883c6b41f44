"""Responses of each cycle that studies use: closure, residual closure and stiffness."""

import numpy as np
import xarray as xr

from jointclosure.engineering.curves import net_responses
from jointclosure.joint.conditions import Conditions


def responses_of(closed: xr.Dataset, conditions: Conditions) -> dict[str, np.ndarray]:
    """Return the responses of each cycle of a joint that was closed to one maximum stress.

    Returns
    -------
    dict of array (cycles,)
        ``closure`` [m], the gross closure from the start of the cycle, as in the paper; and from
        `jointclosure.engineering.curves.net_responses` ``closure_net``, ``closure_seated_net``,
        ``residual_seated_net`` [m] and ``stiffness_net`` [Pa/m]. If breakage makes the stress
        jump over the maximum, the last state below the maximum is used.
    """
    net = net_responses(closed, float(np.max(conditions.max_normal_stress)))
    return {
        "closure": closed.max_closure.values,
        "closure_net": net["max_closure_net"],
        "closure_seated_net": net["max_closure_seated_net"],
        "residual_seated_net": net["residual_closure_seated_net"],
        "stiffness_net": net["stiffness_net"],
    }

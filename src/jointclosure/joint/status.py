"""Status bits and branches of a closed joint, apart from its computation: tables need no solver."""

from typing import Any

FLAGS = {
    1: "target_jumped",
    2: "outside_model_range",
    16: "not_converged",
    32: "breakage_not_at_rest",
    64: "rigid_contact",
    128: "stress_not_reached",
    256: "too_many_steps",
}
"""Bits of a simulation's status: below `FAILURE` remarks on a success, from it on failures."""
TARGET_JUMPED, OUTSIDE_MODEL_RANGE, FAILURE, *_ = FLAGS
LARGEST_UNBREAKABLE_SHARE = 0.1  # of the force on contacts that cannot break, for a valid model
BRANCHES = LOADING, UNLOADING = "loading", "unloading"


def unbreakable_share(joint: Any) -> Any:
    """Return the share of the force on contacts that cannot break, locked or flat."""
    return joint.locked_share + joint.flat_share

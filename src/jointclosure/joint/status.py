"""Status bits, branches and statuses of flow of a simulated joint; it loads no solver."""

from typing import Any, NamedTuple


class Flag(NamedTuple):
    """Bit of the status of a simulation: its name, what it means, and what to do about it.

    ``words`` say the name in a few words, for sentences.
    """

    name: str
    words: str
    meaning: str
    remedy: str


STATUSES = {
    1: Flag(
        "target_jumped",
        "jumped over the maximum stress",
        "breakage made the stress jump over the target, and the maximum is the last state below it",
        "take smaller steps or `breakage: resolved`; on small joints, jumps that remain are real",
    ),
    2: Flag(
        "outside_model_range",
        "outside of the range in which the model holds",
        "contacts that cannot break (flat or locked) carried over 10 % of the force at a maximum",
        "read results at lower stresses, or with care",
    ),
    16: Flag(
        "not_converged",
        "no equilibrium of forces",
        "forces did not reach equilibrium",
        "report the joint to the authors, as no such case is known",
    ),
    32: Flag(
        "breakage_not_at_rest",
        "breakage does not come to rest",
        "breakage continued beyond `most_breakage_steps`",
        "take larger breakage steps, a `largest_radius_mm`, or a larger bound",
    ),
    64: Flag(
        "rigid_contact",
        "a rigid contact overlaps",
        "a flat contact without substrate overlapped",
        "switch the substrate on",
    ),
    128: Flag(
        "stress_not_reached",
        "the maximum stress is not reached",
        "the target is not reached at twice the depth of all voids",
        "lower the maximum stress, or switch gouge on",
    ),
    256: Flag(
        "too_many_steps",
        "too many steps",
        "loading needs more than `most_steps` displacement steps",
        "take larger displacement steps, or a larger bound",
    ),
}
"""Bits of a simulation's status: below `FAILURE` remarks on a success, from it on failures."""
FLAGS = {bit: flag.name for bit, flag in STATUSES.items()}
"""Names of the status bits, by bit."""
TARGET_JUMPED, OUTSIDE_MODEL_RANGE, FAILURE, BREAKAGE_NOT_AT_REST, *_ = FLAGS
LARGEST_UNBREAKABLE_SHARE = 0.1  # of the force on contacts that cannot break, for a valid model
BRANCHES = LOADING, UNLOADING = "loading", "unloading"
FLOW_STATUSES = "flows", "blocked", "at_least", "not_solved"
"""Words of the status of a flow, from that of a solved flow to that of an unknown one."""
ONLY_BOUNDS = FLOW_STATUSES[2:]
"""Statuses at which the hydraulic aperture is missing, and only its bounds are known."""


def flags_of(status: int) -> list[Flag]:
    """Return the flags of all bits that are set in the status of a simulation."""
    return [flag for bit, flag in STATUSES.items() if status & bit]


def failed(joint: Any) -> bool:
    """Return whether the simulation of a joint, given by its Dataset, failed, by its status."""
    return int(joint.status) >= FAILURE


def unbreakable_share(joint: Any) -> Any:
    """Return the share of the force on contacts that cannot break, locked or flat, of a state."""
    return joint.locked_share + joint.flat_share

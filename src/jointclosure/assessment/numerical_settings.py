"""Settings of the numerics that an assessment compares, from the cheapest to the finest."""

from jointclosure.parameters import RESOLVED, Numerics
from jointclosure.uncertainty.sources import coarser

REFINEMENT = 5.0  # tolerance of a resolved setting over that of the next finer one


def named(numerics: Numerics) -> str:
    """Return the name of resolved breakage as a setting."""
    return f"tolerance {numerics.tolerance:g}"


def ladder_about(middle: Numerics) -> dict[str, Numerics]:
    """Return settings of the numerics, from the cheapest to the finest.

    They are the paper's steps, and five times, once and a fifth of the tolerance of ``middle``.
    """
    resolved = (coarser(middle, REFINEMENT**power) for power in (1, 0, -1))
    return {"the paper's steps": Numerics()} | {named(numerics): numerics for numerics in resolved}


LADDER = ladder_about(RESOLVED)
"""Settings of the numerics that are compared, unless the scene states a finer one."""
FINEST = list(LADDER.values())[-1]

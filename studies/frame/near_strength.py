"""Points whose maximum stress is near the stress that all cells of the walls carry together.

Nearly all of their cells break, and their joints take many times as long as others
(docs/hard_cases.md). They are found without walls, before a joint is simulated.
"""

from collections.abc import Iterable, Sequence
from functools import cache

from jointclosure.joint.checked_conditions import CheckedConditions
from jointclosure.joint.feasibility import largest_stress
from jointclosure.joint.simulation import NEAR_STRENGTH
from jointclosure.parameters import Numerics
from jointclosure.statistics.number_texts import percent
from studies.frame.pilots import tried
from studies.frame.settings import Point

MOST_NAMED = 4
"""Largest number of cases that are named in a note."""


@cache
def share_of_strength(conditions: CheckedConditions) -> float:
    """Return the maximum stress over that which all cells of the walls carry together [1].

    It is 0 where nothing bounds this stress. If only radii are bounded, cells may carry less, and
    the share may be larger.
    """
    # joints by fixed steps become as slow, but are not refused
    numerics = Numerics(breakage="resolved", tolerance=conditions.numerics.tolerance)
    model = conditions.rock, conditions.effects, conditions.choices, numerics
    return conditions.largest_stress / largest_stress(*model, conditions.grid_spacing)


def is_near_strength(point: Point) -> bool:
    """Return whether joints of a point take many times as long as at lower stresses."""
    return share_of_strength(point.settings.conditions) >= NEAR_STRENGTH


def tried_by_strength(points: Iterable[Point]) -> list[tuple[list[Point], int]]:
    """Group points as `tried` does, with those near the strength in groups of their own.

    If such a group has only one point, two of its joints are tried, so that the error of their time
    is known.
    """
    points = list(points)
    near = tried(point for point in points if is_near_strength(point))
    usual = tried(point for point in points if not is_near_strength(point))
    return usual + [([*group, *_second_joint(group)], joints) for group, joints in near]


def _second_joint(points: Sequence[Point]) -> list[Point]:
    """Return the only one of some points from its second joint on; none if it has no such joint."""
    settings = points[0].settings
    if len(points) > 1 or settings.realizations < 2 or settings.walls:
        return []
    first = settings.first_realization + 1
    return [points[0]._replace(settings=settings._replace(first_realization=first))]


def notes_near_strength(points: Iterable[Point]) -> list[str]:
    """Return a note that names the cases near the strength; none if there are none."""
    shares = {
        point.settings.case.label: share_of_strength(point.settings.conditions)
        for point in points
        if is_near_strength(point)
    }
    if not shares:
        return []
    named = [f"{label} ({percent(share)})" for label, share in shares.items()]
    further = len(named) - MOST_NAMED
    named = [*named[:MOST_NAMED], *([f"{further} more"] if further > 0 else [])]
    return [
        f"near the strength: {', '.join(named)} of the stress that all cells together carry. "
        "Nearly all of their cells break, and their joints may take many times as long as at lower "
        "stresses (docs/hard_cases.md#near-the-strength); they were timed apart from the others"
    ]

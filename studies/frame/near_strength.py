"""Points of a study near the strength: nearly the stress that all cells of the walls carry.

Nearly all cells of their joints break, and these take many times as long as others
(docs/hard_cases.md). Such points are found before a joint is simulated, without its walls.
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
"""Largest number of cases that a note names."""


@cache
def share_of_strength(conditions: CheckedConditions) -> float:
    """Return the maximum stress over the stress that all cells of the walls carry together [1].

    It is 0 if nothing bounds the stress that they carry. If only the radii of contacts are bounded,
    they may carry less, so that the true share may be larger.
    """
    # joints by fixed steps become as slow, but are not refused
    numerics = Numerics(breakage="resolved", tolerance=conditions.numerics.tolerance)
    model = conditions.rock, conditions.effects, conditions.choices, numerics
    return conditions.largest_stress / largest_stress(*model, conditions.grid_spacing)


def is_near_strength(point: Point) -> bool:
    """Return whether a point is near the strength (its share is at least `NEAR_STRENGTH`)."""
    return share_of_strength(point.settings.conditions) >= NEAR_STRENGTH


def tried_by_strength(points: Iterable[Point]) -> list[tuple[list[Point], int]]:
    """Return the groups of points that `tried` returns; points near the strength have own groups.

    If such a group has only one point, two of its joints are tried, so that the error of the mean
    time is known.
    """
    points = list(points)
    near = tried(point for point in points if is_near_strength(point))
    usual = tried(point for point in points if not is_near_strength(point))
    return usual + [([*group, *_second_joint(group)], joints) for group, joints in near]


def _second_joint(points: Sequence[Point]) -> list[Point]:
    """Return a list with the only point of a group, beginning with its second joint.

    The list is empty if there are several points, or only one joint, or if walls were scanned.
    """
    settings = points[0].settings
    if len(points) > 1 or settings.realizations < 2 or settings.walls:
        return []
    first = settings.first_realization + 1
    return [points[0]._replace(settings=settings._replace(first_realization=first))]


def notes_near_strength(points: Iterable[Point]) -> list[str]:
    """Return a list with a note that names the cases near the strength; it may be empty."""
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

"""Plan of the joints that are simulated by variants for the assessment in the report of a study.

The joints take at most a share of the study's time; a minute of processor time is allowed in any
case, for the few joints without which nothing could be decided. The plan follows from expected
times only, so that a configuration has the same plan on every machine. Joints with the settings of
the study are taken from its dataset, unless these have flow or effects left out automatically.
"""

import math
from collections.abc import Iterator, Sequence
from typing import NamedTuple

import pandas as pd

from jointclosure.assessment.assess import assessed_variants
from jointclosure.assessment.assessed_results import JUDGED, STIFFNESS
from jointclosure.assessment.effect_names import lacks_effects
from jointclosure.assessment.verdicts import is_given_up
from jointclosure.ensembles.simulation import Row
from jointclosure.joint.checked_conditions import CheckedConditions
from jointclosure.uncertainty.expected_cost import relative_cost
from studies.assessment.section import AssessmentSection
from studies.frame.cases import base_case, cases_of, ensembles_of, seconds_by_paper
from studies.frame.configuration import Configuration
from studies.frame.experiments import settings_of
from studies.frame.settings import Point

FEWEST_JOINTS = 2
"""Fewest joints of a rock: the error of the mean of a single joint is not known."""
ENOUGH = 4
"""Number of joints of all rocks together that are simulated, also beyond the share, if they take no
more than `LEAST_SECONDS`. For the same scatter the 95 % interval (Student's t) of the mean of two
joints is six times as long as that of four."""
LEAST_SECONDS = 60.0
"""Expected processor time [s] that joints may take although they exceed the share."""
COSTLY = 5.0
"""Cost of a joint without an effect, over that of a joint of the study, above which this variant is
left out if the share of the time does not allow all variants."""
RESIDUAL = "residual_closure_seated_net"
"""Net closure that remains at the seating stress after unloading."""
READ = (*JUDGED, RESIDUAL, STIFFNESS)
"""Quantities that are read of the planned joints."""


class AssessmentPlan(NamedTuple):
    """Plan of the joints of base cases that are simulated by variants.

    Attributes
    ----------
    stated : str
        Name of the variant with the settings of the study.
    ladder : tuple of str
        Settings of the numerics that are compared, the reference last.
    omitted : tuple of str
        Variants that the share does not allow.
    joints : int
        Number of joints of each rock and variant.
    points : dict
        Points of each rock, one for each variant that is simulated. Empty if even the fewest
        joints of one rock would take more than the share, and more than `LEAST_SECONDS`.
    seconds, study_seconds : float
        Expected processor time [s] of the planned joints (of the fewest if there are no points),
        and of the whole study.
    share : float
        Share of the time of the study that the planned joints may take [1].
    """

    stated: str
    ladder: tuple[str, ...]
    omitted: tuple[str, ...]
    joints: int
    points: dict[str, tuple[Point, ...]]
    seconds: float
    study_seconds: float
    share: float

    @property
    def within(self) -> bool:
        """Whether the planned joints are expected to take no more than the share."""
        return self.seconds <= self.share * self.study_seconds


def ends_variant(point: Point, row: Row) -> bool:
    """Return whether no further joint of a point is simulated after the joint of a row.

    A joint without an effect that was given up decides that the effect is kept.
    """
    lacks = lacks_effects(pd.Series([point.coordinates["variant"]])).any()
    return bool(lacks and is_given_up(pd.Series([row["status"]])).any())


def study_seconds(study: Configuration) -> float:
    """Return the expected processor time [s] of all joints of a study, in all its ensembles."""
    return sum(
        of.study.realizations * seconds_by_paper(of) * _cost(case.checked_conditions)
        for of in ensembles_of(study).values()
        for case in cases_of(of)
    )


def _ladder_of(given: CheckedConditions) -> list[str]:
    return assessed_variants(given._replace(flow=False))[1]


def _cost(conditions: CheckedConditions) -> float:
    return relative_cost(conditions.effects, conditions.numerics)


def planned(study: Configuration) -> AssessmentPlan | None:
    """Return the plan of the joints for the report of a study; None without an assessment.

    First the largest scope (settings and effects that are compared) is taken for which the share of
    time allows `FEWEST_JOINTS` of every rock. Then as many joints are planned as the share allows.
    If it allows not even the smallest scope for every rock, this scope is planned for the first
    rocks only. If fewer than `ENOUGH` joints of all rocks are planned, their number is raised to
    `ENOUGH` if these take at most `LEAST_SECONDS`.
    """
    section = study.section_or_none(AssessmentSection)
    if section is None:
        return None
    of_rocks = {rock: base_case(study, rock).checked_conditions for rock in study.rocks}
    whole = study_seconds(study)
    seconds = seconds_by_paper(study)
    allowed = section.share * whole / seconds  # in joints by the paper's steps
    most = FEWEST_JOINTS if study.study.accuracy else min(section.joints, study.study.realizations)
    again = study.flow or study.effects.auto is not None

    def costs(scope: "_Scope") -> list[float]:
        return [scope.cost(given, again) for given in of_rocks.values()]

    # a rock without breakage has only one setting of the numerics
    scopes = list(_scopes(max(of_rocks.values(), key=lambda given: len(_ladder_of(given)))))
    for scope in scopes:
        if FEWEST_JOINTS * sum(costs(scope)) <= allowed:
            rocks = list(of_rocks)
            joints = min(most, int(allowed / (sum(costs(scope)) or 1.0)))
            break
    else:
        scope = scopes[-1]
        joints = FEWEST_JOINTS
        of_each = costs(scope)
        fitting = [n for n in range(1, len(of_each)) if joints * sum(of_each[:n]) <= allowed]
        rocks = list(of_rocks)[: max(fitting, default=1)]
    each = seconds * sum(costs(scope)[: len(rocks)])
    enough = min(most, math.ceil(ENOUGH / len(rocks)))
    if joints < enough and enough * each <= LEAST_SECONDS:
        joints = enough
    expected = joints * each
    closes = expected <= max(section.share * whole, LEAST_SECONDS)
    of_rock = {rock: scope.points(study, rock, joints, again) for rock in rocks if closes}
    points = {rock: points for rock, points in of_rock.items() if points}
    return AssessmentPlan(
        scope.stated, scope.ladder, scope.omitted, joints, points, expected, whole, section.share
    )


class _Scope(NamedTuple):
    """Scope of an assessment: the variants that are compared. Fields are as in `AssessmentPlan`."""

    stated: str
    ladder: tuple[str, ...]
    omitted: tuple[str, ...]
    costly: bool  # whether variants without an effect whose joints are `COSTLY` are compared too

    def variants(self, given: CheckedConditions, again: bool) -> dict[str, CheckedConditions]:
        """Return the conditions of the variants of a rock that are simulated, by name.

        ``given`` are the conditions of the rock in the study. The stated variant is left out unless
        it is to be simulated ``again``.
        """
        stated, ladder, variants = assessed_variants(given._replace(flow=False))
        most = COSTLY * _cost(given) if not self.costly else float("inf")
        shown = (*self.ladder, *(name for name in variants if name not in ladder))
        return {
            name: variants[name]
            for name in shown
            if name in variants
            and (name in ladder or _cost(variants[name]) <= most)
            and (again or name != stated)
        }

    def cost(self, given: CheckedConditions, again: bool) -> float:
        """Return the cost of simulating one joint of a rock by all variants.

        Its unit is the cost of a joint by the paper's steps with all effects.
        """
        return sum(map(_cost, self.variants(given, again).values()))

    def points(
        self, study: Configuration, rock: str, joints: int, again: bool
    ) -> tuple[Point, ...]:
        """Return the points of a rock, one for each variant, with ``joints`` realisations."""
        settings = settings_of(study, base_case(study, rock))
        settings = settings._replace(realizations=joints, effects_chosen_to=None)
        return tuple(
            Point(
                {"rock": rock, "variant": name},
                settings.under(
                    numerics=conditions.numerics, effects=conditions.effects, flow=False
                ),
            )
            for name, conditions in self.variants(settings.conditions, again).items()
        )


def _scopes(given: CheckedConditions) -> Iterator[_Scope]:
    """Generate scopes of comparison from the largest to the smallest.

    The first has all settings and effects. Then settings are left out, until at least the stated
    setting and a finer one remain. Finally the variants without an effect whose joints are `COSTLY`
    are left out too.
    """
    stated, ladder, variants = assessed_variants(given._replace(flow=False))
    effects = [name for name in variants if name not in ladder]
    costly = [name for name in effects if _cost(variants[name]) > COSTLY * _cost(given)]
    finer = ladder[ladder.index(stated) + 1 :]
    kept: list[Sequence[str]] = [ladder]
    if len(finer) > 1:
        kept += [ladder[:-1], [stated, finer[-2]]]
    elif finer:
        kept += [[*dict.fromkeys((ladder[0], stated)), finer[-1]]]
    for settings in kept:
        yield _Scope(stated, (*settings,), _others(ladder, settings), True)
    if costly:
        omitted = (*_others(ladder, kept[-1]), *costly)
        yield _Scope(stated, (*kept[-1],), omitted, False)


def _others(names: Sequence[str], kept: Sequence[str]) -> tuple[str, ...]:
    return tuple(name for name in names if name not in kept)

"""The rule of each claim: the numbers of the model that decide it, and what a study finds.

By its number in ``jointclosure/config/paper_claims.csv``. Claims 7 and 8 have no rule: a
sensitivity study does not say anything of them.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from jointclosure.studies.sensitivity import claim_findings as findings
from jointclosure.studies.sensitivity import claim_quantities as quantities
from jointclosure.studies.sensitivity.claim_findings import Findings
from jointclosure.studies.sensitivity.claim_quantities import LOOP, Quantity
from jointclosure.studies.sensitivity.responses import NET, TARGET, RockSample

NU, E, STRENGTH, JRC = "poisson_ratio", "youngs_modulus", "compressive_strength", "jrc"
_ALL = frozenset((NU, E, STRENGTH, JRC))


class Rule(NamedTuple):
    """How a claim is judged in one rock; ``figure`` is the number in the claim, or None.

    ``quantities``: numbers that all lie where the claim is true, none where the rock does not
    vary what it is about. ``found``: one boolean for each study (R,), or None.
    ``negated``: the claim is that the rule does *not* hold in every rock.
    """

    quantities: Callable[[RockSample, float | None], list[Quantity]]
    found: Callable[[Findings, str, float | None], np.ndarray | None]
    negated: bool = False


def _varies(sample: RockSample, parameters, *cycles: int) -> bool:
    have = {cycle for _, cycle in sample.names}
    return set(parameters) <= set(sample.levels) and set(cycles) <= have


def _judges(found: Findings, rock: str, parameters, *targets: tuple[str, int]) -> bool:
    return set(parameters) <= set(found.parameters(rock)) and set(targets) <= set(found.names)


def _least_sensitive(cycle: int) -> Rule:
    def numbers(sample, figure):
        if not _varies(sample, _ALL, cycle):
            return []
        others = (E, STRENGTH, JRC)
        return [quantities.more_sensitive(sample, other, NU, cycle) for other in others]

    def found(studies, rock, figure):
        if not _judges(studies, rock, _ALL, (TARGET, cycle)):
            return None
        return findings.widest(studies.percents(rock, cycle), NU)

    return Rule(numbers, found)


def _most_sensitive(cycle: int, variable: str = TARGET) -> Rule:
    def numbers(sample, figure):
        if not _varies(sample, _ALL, cycle):
            return []
        others = (NU, STRENGTH, JRC)
        return [quantities.more_sensitive(sample, E, other, cycle, variable) for other in others]

    def found(studies, rock, figure):
        if not _judges(studies, rock, _ALL, (variable, cycle)):
            return None
        return findings.shortest(studies.percents(rock, cycle, variable), E)

    return Rule(numbers, found)


def _second_most_sensitive(cycle: int) -> Rule:
    def numbers(sample, figure):
        if not _varies(sample, _ALL, cycle):
            return []
        pairs = ((E, STRENGTH), (STRENGTH, NU), (STRENGTH, JRC))
        return [quantities.more_sensitive(sample, *pair, cycle) for pair in pairs]

    def found(studies, rock, figure):
        if not _judges(studies, rock, _ALL, (TARGET, cycle)):
            return None
        return findings.second(studies.percents(rock, cycle), STRENGTH)

    return Rule(numbers, found)


def _no_effect_within_figure() -> Rule:
    def numbers(sample, figure):
        cycles = sorted({cycle for _, cycle in sample.names})
        if not _varies(sample, [NU]):
            return []
        changes = (-figure, figure)
        return [quantities.change_of(sample, NU, c, change) for c in cycles for change in changes]

    def found(studies, rock, figure):
        if not _judges(studies, rock, [NU]):
            return None
        cycles = [cycle for variable, cycle in studies.names if variable == TARGET]
        return np.logical_and.reduce([studies.lengths(rock, NU, c) >= figure for c in cycles])

    return Rule(numbers, found)


def _sensitivity_falls(parameter: str) -> Rule:
    def numbers(sample, figure):
        if not _varies(sample, [parameter], 1, 2):
            return []
        return [quantities.falls_with_the_cycle(sample, parameter)]

    def found(studies, rock, figure):
        if not _judges(studies, rock, [parameter], (TARGET, 1), (TARGET, 2)):
            return None
        return studies.lengths(rock, parameter, 2) > studies.lengths(rock, parameter, 1)

    return Rule(numbers, found)


def _trend(
    parameter: str, cycle: int, sign: int, variable: str = TARGET, negated: bool = False
) -> Rule:
    def numbers(sample, figure):
        if not _varies(sample, [parameter], cycle):
            return []
        return quantities.rises(sample, parameter, cycle, sign, variable)

    def found(studies, rock, figure):
        if not _judges(studies, rock, [parameter], (variable, cycle)):
            return None
        return findings.monotone(studies.means(rock, parameter, variable, cycle), sign)

    return Rule(numbers, found, negated)


def _hysteresis() -> Rule:
    def numbers(sample, figure):
        return [
            quantities.relative(
                sample, 0, f"loop over closure, cycle {c}", (LOOP, c), (TARGET, c), less=False
            )
            for c in sorted({cycle for _, cycle in sample.names})
        ]

    def found(studies, rock, figure):
        cycles = [cycle for variable, cycle in studies.names if variable == LOOP]
        if not cycles:
            return None
        return np.logical_and.reduce([studies.base_means(rock, LOOP, c) > 0.0 for c in cycles])

    return Rule(numbers, found)


def _stiffer() -> Rule:
    def numbers(sample, figure):
        if not _varies(sample, [], 1, 2):
            return []
        name = "1 - closure of cycle 2 over cycle 1"
        return [quantities.relative(sample, 0, name, (TARGET, 2), (TARGET, 1), less=True)]

    def found(studies, rock, figure):
        if not _judges(studies, rock, [], (TARGET, 1), (TARGET, 2)):
            return None
        first, second = (studies.base_means(rock, TARGET, cycle) for cycle in (1, 2))
        return second < first

    return Rule(numbers, found)


RULES: dict[str, Rule] = {
    "1a, cycle 1": _least_sensitive(1),
    "1a, cycle 2": _least_sensitive(2),
    "1b": _no_effect_within_figure(),
    "2a": _most_sensitive(2),
    "2a, net": _most_sensitive(2, NET),
    "2b": _most_sensitive(1),
    "3": _second_most_sensitive(2),
    "4": _sensitivity_falls(JRC),
    "5a": _trend(E, 2, -1),
    "5a, net": _trend(E, 2, -1, NET),
    "5b": _trend(STRENGTH, 2, 1),
    "5c": _trend(JRC, 1, 1),
    "5d": _trend(JRC, 2, 1, negated=True),
    "6a": _hysteresis(),
    "6b": _stiffer(),
}

"""Results of many studies at once, judged as in the paper by point estimates.

Studies are those of `jointclosure.statistics.drawn_studies.draw_studies`: lengths and means of R
repetitions. A real study is a study with R = 1, judged by the same rules.
"""

from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

import numpy as np

from jointclosure import parameters
from jointclosure.statistics.drawn_studies import DrawnResponse
from jointclosure.statistics.verdicts import FALLS, STANDS, Interval, verdict

TARGET, NET = "max_closure", "max_closure_net"
"""Names of the maximum closure, and of the maximum closure net of bulk indentation."""
LOOP = "loop"
"""Name of the loop: closure of unloading less that of loading, at half the maximum stress."""
EXCESS = "excess"
"""Name of the excess at low stress: closure of loading to half the maximum stress, since the start
of the cycle, less half of the maximum closure."""


class Findings(NamedTuple):
    """Studies (R) of some rocks: responses by (rock, parameter), and names of the targets."""

    drawn: dict[tuple[str, str], DrawnResponse]
    names: tuple[tuple[str, int], ...]

    def rocks(self) -> list[str]:
        """Return the names of the rocks, in order."""
        return list(dict.fromkeys(rock for rock, _ in self.drawn))

    def parameters(self, rock: str) -> list[str]:
        """Return the parameters of a rock that are varied."""
        return [parameter for name, parameter in self.drawn if name == rock]

    def percents(self, rock: str, cycle: int, variable: str = TARGET) -> dict[str, np.ndarray]:
        """Return lengths (R,) in percent of the rock's value, by parameter; infinite if no root."""
        target = self.names.index((variable, cycle))
        return {
            parameter: 100.0 * response.lengths[:, target] / abs(response.base)
            for parameter in self.parameters(rock)
            if (response := self.drawn[rock, parameter]).base != 0.0
        }

    def lengths(self, rock: str, parameter: str, cycle: int, variable: str = TARGET) -> np.ndarray:
        """Return lengths (R,) [SI]."""
        return self.drawn[rock, parameter].lengths[:, self.names.index((variable, cycle))]

    def means(self, rock: str, parameter: str, variable: str, cycle: int) -> np.ndarray:
        """Return means (R, levels)."""
        return self.drawn[rock, parameter].means[:, self.names.index((variable, cycle))]

    def base_means(self, rock: str, variable: str, cycle: int) -> np.ndarray:
        """Return means (R,) of the base case of the rock."""
        parameter = self.parameters(rock)[0]
        response = self.drawn[rock, parameter]
        at_base = int(np.flatnonzero(response.levels == response.base)[0])
        return self.means(rock, parameter, variable, cycle)[:, at_base]


def widest(percents: dict[str, np.ndarray], parameter: str) -> np.ndarray:
    """Return whether no other interval is longer, and some are finite."""
    every = np.array(list(percents.values()))
    return (percents[parameter] >= every.max(axis=0)) & np.isfinite(every).any(axis=0)


def in_place(percents: dict[str, np.ndarray], parameter: str, place: int) -> np.ndarray:
    """Return whether ``place`` other intervals are shorter, and this one is finite."""
    every = np.array(list(percents.values()))
    shorter = (every < percents[parameter]).sum(axis=0)
    return (shorter == place) & np.isfinite(percents[parameter])


def monotone(means: np.ndarray, sign: int) -> np.ndarray:
    """Return whether means (R, levels) rise (sign 1) or fall (-1) at every step of the levels."""
    return np.all(sign * np.diff(means, axis=1) > 0.0, axis=1)


NU, E, STRENGTH, JRC = "poisson_ratio", "youngs_modulus", "compressive_strength", "jrc"
PROPERTIES = (NU, E, STRENGTH, JRC)
"""Properties that the claims of the paper concern."""
SYMBOLS = {name: parameters.PROPERTIES[name].symbol for name in PROPERTIES}

NEGLIGIBLE = 0.02
"""Relative change of a closure that counts as none: the tolerance at which `effects: auto` leaves
an effect out, and less than the difference of repeated measurements of a closure."""
TOLERANCE = NEGLIGIBLE / 0.2
"""Difference of elasticities that counts as none. A property of one rock is known to a fifth at
best; such a change then changes the closure by less than `NEGLIGIBLE`."""

Value = Any
"""Number, or array of numbers."""
Margins = Mapping[str, Value]
"""Margins by name: numbers, or arrays of equal shape."""


Model = Any
"""Model of a rock: `studies.paper.judged_claims.ClosedModel`, or its `Elasticities` alone."""


class Elasticities(NamedTuple):
    """Elasticities by (parameter, cycle), as known from some studies of a rock.

    ``bases``: the rock's values of the parameters.
    """

    by_cycle: Mapping[tuple[str, int], Value]
    bases: Mapping[str, float]

    def elasticity(self, parameter: str, cycle: int, variable: str = TARGET) -> Value:
        """Return d ln(closure)/d ln(parameter) at the rock's value; only one variable is known."""
        return self.by_cycle[parameter, cycle]

    def slopes(self, parameter: str, cycle: int, variable: str = TARGET) -> list[Value]:
        """Return the elasticity itself in place of those between levels."""
        return [self.elasticity(parameter, cycle, variable)]

    def change(self, parameter: str, cycle: int, change: float) -> Value:
        """Return the relative change of the closure with a change, by a power of the parameter."""
        return (1.0 + change / self.bases[parameter]) ** self.elasticity(parameter, cycle) - 1.0


class Statement(NamedTuple):
    """Statement on a closure (``variable``) of a ``cycle``, and its criteria in one rock.

    ``number`` and ``text`` do not depend on the cycle. ``parameters`` must vary. ``margins``
    (model, cycle, variable) are those of a model; ``finds`` (studies, rock, cycle, variable)
    returns for each study (R,) whether it confirms the statement. The statement is true if all
    margins exceed ``above``. ``alike`` is the largest difference that counts as none, for
    comparisons; a statement that is no comparison is false below ``above``. ``within``: the
    statement is true if all margins lie within +-``above`` instead. ``before``: it compares with
    the cycle before. ``of_elasticities``: it depends only on elasticities and the rock's values.
    ``reads``: `LOOP` or `EXCESS` of the base case, if it is judged by that.
    """

    number: str
    text: str
    parameters: tuple[str, ...]
    margins: Callable[..., Margins]
    finds: Callable[[Findings, str, int, str], np.ndarray]
    above: float = TOLERANCE
    alike: float | None = None
    within: bool = False
    before: bool = False
    of_elasticities: bool = True
    reads: str = ""

    def cycles(self, cycle: int) -> tuple[int, ...]:
        """Return the cycles that the statement needs."""
        return (cycle - 1, cycle) if self.before else (cycle,)

    def least(self, model: Model, cycle: int, variable: str = TARGET) -> np.ndarray:
        """Return the smallest of its margins; with ``within`` the least distance to the bound."""
        margins = list(self.margins(model, cycle, variable).values())
        if self.within:
            return self.above - np.max(np.abs(margins), axis=0)
        return np.min(margins, axis=0)

    def least_interval(self, intervals: list[Interval]) -> Interval:
        """Return the confidence interval of the smallest margin from simultaneous intervals.

        With ``within`` it is the interval of the distance to the bound.
        """
        if self.within:
            intervals = [
                Interval(self.above - max(abs(low), abs(high)), self.above - max(low, -high, 0.0))
                for low, high in intervals
            ]
        return Interval(*(min(ends) for ends in zip(*intervals, strict=True)))

    def true_above(self) -> float:
        """Smallest margin for which the statement is true."""
        return 0.0 if self.within else self.above


def _size(model: Model, parameter: str, cycle: int, variable: str) -> Value:
    return np.abs(model.elasticity(parameter, cycle, variable))


def _less(first: str, second: str) -> str:
    return f"|e({SYMBOLS[first]})| - |e({SYMBOLS[second]})|"


def _ranked(number: str, text: str, pairs: list[tuple[str, str]], finds: Callable) -> Statement:
    """Make the statement that closure is more sensitive to the first of each pair."""

    def margins(model: Model, cycle: int, variable: str) -> Margins:
        size = {name: _size(model, name, cycle, variable) for name in PROPERTIES}
        return {_less(one, other): size[one] - size[other] for one, other in pairs}

    def confirms(studies: Findings, rock: str, cycle: int, variable: str) -> np.ndarray:
        return finds(studies.percents(rock, cycle, variable))

    return Statement(number, text, PROPERTIES, margins, confirms, alike=TOLERANCE)


def _with_the_cycle(number: str, text: str, parameter: str, sign: int) -> Statement:
    """Make the statement that sensitivity rises (sign 1) or falls (-1) from the cycle before."""

    def margins(model: Model, cycle: int, variable: str) -> Margins:
        before, here = (_size(model, parameter, c, variable) for c in (cycle - 1, cycle))
        of = f"|e({SYMBOLS[parameter]})| of cycle"
        pair = (cycle, cycle - 1) if sign > 0 else (cycle - 1, cycle)
        return {f"{of} {pair[0]} - {pair[1]}": sign * (here - before)}

    def confirms(studies: Findings, rock: str, cycle: int, variable: str) -> np.ndarray:
        before, here = (studies.lengths(rock, parameter, c, variable) for c in (cycle - 1, cycle))
        return here < before if sign > 0 else here > before

    return Statement(number, text, (parameter,), margins, confirms, alike=TOLERANCE, before=True)


def _trend(number: str, text: str, parameter: str, sign: int) -> Statement:
    """Make the statement that closure rises (sign 1) or falls (-1) with a parameter."""
    word = "rise" if sign > 0 else "fall"

    def margins(model: Model, cycle: int, variable: str) -> Margins:
        name = f"{word} with {SYMBOLS[parameter]}"
        slopes = model.slopes(parameter, cycle, variable)
        return {f"{name}, step {i + 1}": sign * slope for i, slope in enumerate(slopes)}

    def confirms(studies: Findings, rock: str, cycle: int, variable: str) -> np.ndarray:
        return monotone(studies.means(rock, parameter, variable, cycle), sign)

    return Statement(number, text, (parameter,), margins, confirms)


def _no_effect(number: str, text: str, parameter: str, change: float) -> Statement:
    """Make the statement that this change of a parameter has a negligible effect on the closure."""

    def margins(model: Model, cycle: int, variable: str) -> Margins:
        return {
            f"change with {SYMBOLS[parameter]} {by:+g}": model.change(parameter, cycle, by)
            for by in (-change, change)
        }

    def confirms(studies: Findings, rock: str, cycle: int, variable: str) -> np.ndarray:
        return studies.lengths(rock, parameter, cycle, variable) >= change

    return Statement(number, text, (parameter,), margins, confirms, NEGLIGIBLE, within=True)


def _significant(number: str, text: str, parameter: str, percent: float) -> Statement:
    """Make the statement that this change of a parameter is significant in a study."""
    name = f"change with {percent:g} % of {SYMBOLS[parameter]}, over a significant one"

    def margins(model: Model, cycle: int, variable: str) -> Margins:
        change = 0.01 * percent * np.abs(model.elasticity(parameter, cycle, variable))
        return {name: change / model.significant(cycle)}

    def confirms(studies: Findings, rock: str, cycle: int, variable: str) -> np.ndarray:
        return studies.percents(rock, cycle, variable)[parameter] <= percent

    return Statement(number, text, (parameter,), margins, confirms, 1.0, of_elasticities=False)


def _positive(number: str, text: str, reads: str) -> Statement:
    """Make the statement that `LOOP` or `EXCESS` is positive."""

    def margins(model: Model, cycle: int, variable: str) -> Margins:
        return {f"{reads} over closure": model.share(reads, cycle)}

    def confirms(studies: Findings, rock: str, cycle: int, variable: str) -> np.ndarray:
        return studies.base_means(rock, reads, cycle) > 0.0

    return Statement(
        number, text, (), margins, confirms, NEGLIGIBLE, of_elasticities=False, reads=reads
    )


NU_LEAST = _ranked(
    "1a",
    "Poisson's ratio matters least",
    [(name, NU) for name in (E, STRENGTH, JRC)],
    lambda percents: widest(percents, NU),
)
NU_NO_EFFECT = _no_effect("1b", "No effect of a change of Poisson's ratio by 0.1", NU, 0.1)
E_MOST = _ranked(
    "2a",
    "Young's modulus matters most",
    [(E, name) for name in (NU, STRENGTH, JRC)],
    lambda percents: in_place(percents, E, 0),
)
E_RISES = _with_the_cycle("2c", "Young's modulus matters more than on the cycle before", E, 1)
STRENGTH_NEXT = _ranked(
    "3",
    "Compressive strength matters next after Young's modulus",
    [(E, STRENGTH), (STRENGTH, NU), (STRENGTH, JRC)],
    lambda percents: in_place(percents, STRENGTH, 1),
)
STRENGTH_RISES = _with_the_cycle(
    "3b", "Compressive strength matters more than on the cycle before", STRENGTH, 1
)
STRENGTH_SIGNIFICANT = _significant(
    "3c", "A change of compressive strength by 5 % is significant", STRENGTH, 5.0
)
JRC_FALLS = _with_the_cycle("4", "JRC matters less than on the cycle before", JRC, -1)
FALLS_WITH_E = _trend("5a", "Closure rises when E falls", E, -1)
RISES_WITH_STRENGTH = _trend("5b", "Closure rises when sigma_c rises", STRENGTH, 1)
RISES_WITH_JRC = _trend("5c", "Closure falls when JRC falls", JRC, 1)
HYSTERESIS = _positive("6a", "Unloading shows hysteresis", LOOP)
SOFT_AT_FIRST = _positive("6b", "Low stresses close more than high ones", EXCESS)


OURS = "ours"
"""Source of a claim that is a variant added here and not in the paper."""
TABLE_3 = "table 3"


class Claim(NamedTuple):
    """Claim: a statement on some cycles, of gross or net closures.

    ``section``: sections of the paper, or `OURS`. ``statement``: None for a claim that no
    sensitivity study can judge; ``remark`` states the reason, or what its verdict rests on.
    ``shown``: where the paper has numbers for it, `TABLE_3` for entries of ``parameter``.
    ``negated``: the claim is that the statement is *not* true in every rock.
    """

    number: str
    text: str
    section: str
    statement: Statement | None
    cycles: tuple[int, ...]
    shown: str = TABLE_3
    parameter: str = ""
    variable: str = TARGET
    negated: bool = False
    remark: str = ""

    @property
    def judged_by(self) -> Statement:
        """Statement of the claim."""
        if self.statement is None:
            raise ValueError(f"claim {self.number}: {self.remark}")
        return self.statement

    def verdict(self, least: tuple[float, float]) -> str:
        """Return the verdict from the confidence interval of the smallest margin in all rocks."""
        word = verdict(least, self.judged_by.true_above(), self.judged_by.alike)
        return {STANDS: FALLS, FALLS: STANDS}.get(word, word) if self.negated else word

    def cycles_among(self, names: tuple[tuple[str, int], ...]) -> list[int]:
        """Return cycles with all targets (variable, cycle) that the statement needs."""
        if self.statement is None:
            return []
        cycles = {cycle for variable, cycle in names if variable == self.variable}
        return [cycle for cycle in self.cycles if cycles.issuperset(self.statement.cycles(cycle))]

    def margins(self, model: Model, cycles: list[int]) -> dict[tuple[str, int], Value]:
        """Return the margins of the statement by name and cycle."""
        return {
            (name, cycle): value
            for cycle in cycles
            for name, value in self.judged_by.margins(model, cycle, self.variable).items()
        }

    def found_in(self, studies: Findings) -> np.ndarray | None:
        """Return whether studies (R,) confirm it for all rocks; None if no rock can be judged."""
        cycles = self.cycles_among(studies.names)
        if self.statement is None or not cycles:
            return None
        rocks = [
            rock
            for rock in studies.rocks()
            if set(self.statement.parameters) <= set(studies.parameters(rock))
        ]
        if not rocks:
            return None
        by_rock = [
            self.statement.finds(studies, rock, cycle, self.variable)
            for rock in rocks
            for cycle in cycles
        ]
        every = np.logical_and.reduce(by_rock)
        return ~every if self.negated else every


HERTZ_EXCESS = 0.5 ** (2.0 / 3.0) - 0.5
"""Excess at half the stress over the closure of one Hertz contact, Eq. (5)."""

_BOTH = "Sections 6, 7"
_MOST = "Abstract, Sections 1, 6, 7"
_NEXT = "Abstract, Section 6"
_NOT_SHOWN = "described, not shown"
_FIG_5 = "Fig. 5"

CLAIMS = (
    Claim("1a, cycle 1", "Poisson's ratio matters least on the first cycle", _BOTH,
          NU_LEAST, (1,), parameter="poisson_ratio"),
    Claim("1a, cycle 2", "Poisson's ratio matters least on the second cycle", _BOTH,
          NU_LEAST, (2,), parameter="poisson_ratio"),
    Claim("1b", "No effect of a change of Poisson's ratio by ±0.1", _NEXT,
          NU_NO_EFFECT, (1, 2), parameter="poisson_ratio"),
    Claim("2a", "Young's modulus is the most sensitive parameter on the second cycle", _MOST,
          E_MOST, (2,), parameter="youngs_modulus"),
    Claim("2a, net", "Young's modulus is the most sensitive parameter on the second cycle, net of "
          "bulk indentation", OURS, E_MOST, (2,), parameter="youngs_modulus",
          variable=NET),
    Claim("2b", "Young's modulus is the most sensitive parameter on the first cycle", _MOST,
          E_MOST, (1,), parameter="youngs_modulus"),
    Claim("2c", "Sensitivity to Young's modulus rises from the first cycle to the second",
          "Section 6", E_RISES, (2,), parameter="youngs_modulus"),
    Claim("3, cycle 1", "Compressive strength is the next sensitive parameter on the first cycle",
          _NEXT, STRENGTH_NEXT, (1,), parameter="compressive_strength"),
    Claim("3, cycle 2", "Compressive strength is the next sensitive parameter on the second cycle",
          _NEXT, STRENGTH_NEXT, (2,), parameter="compressive_strength"),
    Claim("3b", "Sensitivity to compressive strength rises from the first cycle to the second",
          "Section 6", STRENGTH_RISES, (2,), parameter="compressive_strength"),
    Claim("3c", "A change of compressive strength by 5 % is significant on the second cycle",
          "Section 6", STRENGTH_SIGNIFICANT, (2,), parameter="compressive_strength"),
    Claim("4", "Sensitivity to JRC falls from the first cycle to the second", _NEXT,
          JRC_FALLS, (2,), parameter="jrc"),
    Claim("5a", "Cycle-2 closure rises when E falls", _BOTH, FALLS_WITH_E, (2,),
          _NOT_SHOWN),
    Claim("5a, net", "Cycle-2 closure rises when E falls, net of bulk indentation", OURS,
          FALLS_WITH_E, (2,), _NOT_SHOWN, variable=NET),
    Claim("5b", "Cycle-2 closure rises when sigma_c rises", _BOTH,
          RISES_WITH_STRENGTH, (2,), _NOT_SHOWN),
    Claim("5c", "Cycle-1 closure falls when JRC falls", "Section 6", RISES_WITH_JRC,
          (1,), _NOT_SHOWN),
    Claim("5d", "Cycle-2 closure has no such trend with JRC in every rock", "Section 6",
          RISES_WITH_JRC, (2,), _NOT_SHOWN, negated=True),
    Claim("6a", "Unloading shows hysteresis on both cycles", "Abstract, Section 5",
          HYSTERESIS, (1, 2), _FIG_5, remark="by construction: an unloading that broke "
          "nothing is the curve of the next loading, so cycle 2 has no loop"),
    Claim("6b", "Excess deformation at low stress survives on the second cycle", "Sections 3, 5",
          SOFT_AT_FIRST, (2,), _FIG_5, remark="by construction of a stiffening contact, "
          f"{HERTZ_EXCESS:.2f} of the closure for Hertz's; the measured curves are not available"),
    Claim("8", "The model fits Bandis' curves, dolerite worst, second cycles worse", "Section 5",
          None, (), _FIG_5, remark="the measured curves are not available"),
)  # fmt: skip
"""All claims, in the order in which they are shown."""


def statements_of_elasticities() -> list[Statement]:
    """Return the distinct statements that depend only on elasticities."""
    by_number = {claim.statement.number: claim.statement for claim in CLAIMS if claim.statement}
    return [statement for statement in by_number.values() if statement.of_elasticities]

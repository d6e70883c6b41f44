"""Statements of the paper on the closure of a cycle: their margins, and criteria of studies.

A margin is a number of the model that increases with the truth of a statement. Most are
elasticities, d ln(closure)/d ln(parameter), or differences between their magnitudes. These do not
depend on the number of surfaces, unlike the lengths of Table 3 in percent, which are proportional
to the scatter over the magnitude.
"""

from collections.abc import Callable, Mapping
from typing import Any, NamedTuple, Protocol

import numpy as np

from jointclosure import parameters
from jointclosure.statistics.verdicts import Interval
from studies.paper.claims.findings import EXCESS, LOOP, TARGET, Findings, in_place, monotone, widest

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


class Elastic(Protocol):
    """Model of a rock with known elasticities."""

    def elasticity(self, parameter: str, cycle: int, variable: str = TARGET) -> Value:
        """Return d ln(closure)/d ln(parameter) at the rock's value."""
        ...

    def slopes(self, parameter: str, cycle: int, variable: str = TARGET) -> list[Value]:
        """Return the elasticities between neighbouring levels, if levels are known."""
        ...


class Closed(Elastic, Protocol):
    """Model of a rock with known closures at all levels."""

    def change(self, parameter: str, cycle: int, change: float) -> Value:
        """Return the relative change of the closure with a change of the parameter."""
        ...

    def share(self, variable: str, cycle: int) -> Value:
        """Return `LOOP` or `EXCESS` over the closure."""
        ...

    def significant(self, cycle: int) -> Value:
        """Return the smallest relative change of mean closure that a study finds significant."""
        ...


class Elasticities(NamedTuple):
    """Elasticities by (parameter, cycle), as known from some studies of a rock.

    ``bases``: the rock's values of the parameters.
    """

    by_cycle: Mapping[tuple[str, int], Value]
    bases: Mapping[str, float]

    def elasticity(self, parameter: str, cycle: int, variable: str = TARGET) -> Value:
        """Return the elasticity as `Elastic`; only one variable is known."""
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

    def least(self, model: Elastic, cycle: int, variable: str = TARGET) -> np.ndarray:
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
                Interval(
                    self.above - max(abs(low), abs(high)),
                    self.above - max(low, -high, 0.0),
                )
                for low, high in intervals
            ]
        return Interval(*(min(ends) for ends in zip(*intervals, strict=True)))

    def true_above(self) -> float:
        """Smallest margin for which the statement is true."""
        return 0.0 if self.within else self.above


def _size(model: Elastic, parameter: str, cycle: int, variable: str) -> Value:
    return np.abs(model.elasticity(parameter, cycle, variable))


def _less(first: str, second: str) -> str:
    return f"|e({SYMBOLS[first]})| - |e({SYMBOLS[second]})|"


def _ranked(number: str, text: str, pairs: list[tuple[str, str]], finds: Callable) -> Statement:
    """Make the statement that closure is more sensitive to the first of each pair."""

    def margins(model: Elastic, cycle: int, variable: str) -> Margins:
        size = {name: _size(model, name, cycle, variable) for name in PROPERTIES}
        return {_less(one, other): size[one] - size[other] for one, other in pairs}

    def confirms(studies: Findings, rock: str, cycle: int, variable: str) -> np.ndarray:
        return finds(studies.percents(rock, cycle, variable))

    return Statement(number, text, PROPERTIES, margins, confirms, alike=TOLERANCE)


def _with_the_cycle(number: str, text: str, parameter: str, sign: int) -> Statement:
    """Make the statement that sensitivity rises (sign 1) or falls (-1) from the cycle before."""

    def margins(model: Elastic, cycle: int, variable: str) -> Margins:
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

    def margins(model: Elastic, cycle: int, variable: str) -> Margins:
        name = f"{word} with {SYMBOLS[parameter]}"
        slopes = model.slopes(parameter, cycle, variable)
        return {f"{name}, step {i + 1}": sign * slope for i, slope in enumerate(slopes)}

    def confirms(studies: Findings, rock: str, cycle: int, variable: str) -> np.ndarray:
        return monotone(studies.means(rock, parameter, variable, cycle), sign)

    return Statement(number, text, (parameter,), margins, confirms)


def _no_effect(number: str, text: str, parameter: str, change: float) -> Statement:
    """Make the statement that this change of a parameter has a negligible effect on the closure."""

    def margins(model: Closed, cycle: int, variable: str) -> Margins:
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

    def margins(model: Closed, cycle: int, variable: str) -> Margins:
        change = 0.01 * percent * np.abs(model.elasticity(parameter, cycle, variable))
        return {name: change / model.significant(cycle)}

    def confirms(studies: Findings, rock: str, cycle: int, variable: str) -> np.ndarray:
        return studies.percents(rock, cycle, variable)[parameter] <= percent

    return Statement(number, text, (parameter,), margins, confirms, 1.0, of_elasticities=False)


def _positive(number: str, text: str, reads: str) -> Statement:
    """Make the statement that `LOOP` or `EXCESS` is positive."""

    def margins(model: Closed, cycle: int, variable: str) -> Margins:
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

"""Statements of the paper on the closure of a cycle: their margins, and how a study finds them.

A margin is a number of the model that is the larger the more a statement is true. Most are
elasticities, d ln(closure)/d ln(parameter), or differences between their sizes: no number of
surfaces changes these, while the lengths of Table 3 in percent go as the scatter over them.
"""

from collections.abc import Callable, Mapping
from typing import NamedTuple, Protocol

import numpy as np

from jointclosure import parameters
from jointclosure.claims.found import LOOP, TARGET, Findings, in_place, monotone, widest
from jointclosure.statistics.verdicts import Interval

NU, E, STRENGTH, JRC = "poisson_ratio", "youngs_modulus", "compressive_strength", "jrc"
PROPERTIES = (NU, E, STRENGTH, JRC)
"""Properties that the paper's claims are about."""
SYMBOLS = {name: parameters.PROPERTIES[name].symbol for name in PROPERTIES}

NEGLIGIBLE = 0.02
"""Relative change of a closure that counts as none: the tolerance to which `effects: auto`
leaves an effect out, and less than repeated measurements of a closure differ by."""
TOLERANCE = NEGLIGIBLE / 0.2
"""Elasticities that differ by less count as alike. A property of one rock is known to a fifth at
best; a change by as much then changes the closure by less than `NEGLIGIBLE`."""

Margins = Mapping[str, np.ndarray]
"""Margins by name: numbers, or arrays alike in shape."""


class Elastic(Protocol):
    """A model of a rock of which elasticities are known."""

    def elasticity(self, parameter: str, cycle: int, variable: str = TARGET) -> np.ndarray:
        """d ln(closure)/d ln(parameter) at the rock's own value."""
        ...

    def slopes(self, parameter: str, cycle: int, variable: str = TARGET) -> list[np.ndarray]:
        """The same from each level to the next, where levels are known."""
        ...


class Closed(Elastic, Protocol):
    """A model of a rock whose closures at all levels are known."""

    def change(self, parameter: str, cycle: int, change: float) -> np.ndarray:
        """Relative change of the closure with a change of the parameter."""
        ...

    def loop(self, cycle: int) -> np.ndarray:
        """Loop over the closure, see `LOOP`."""
        ...

    def significant(self, cycle: int) -> np.ndarray:
        """Relative change of the mean closure that a study of the paper's size finds."""
        ...


class Elasticities(NamedTuple):
    """Elasticities by (parameter, cycle): what some studies know of a rock."""

    by_cycle: Mapping[tuple[str, int], np.ndarray]

    def elasticity(self, parameter: str, cycle: int, variable: str = TARGET) -> np.ndarray:
        """As of `Elastic`; of one variable only."""
        return self.by_cycle[parameter, cycle]

    def slopes(self, parameter: str, cycle: int, variable: str = TARGET) -> list[np.ndarray]:
        """As of `Elastic`: the elasticity itself."""
        return [self.elasticity(parameter, cycle, variable)]


class Statement(NamedTuple):
    """What is said of a closure (``variable``) on a ``cycle``, and how it is judged in one rock.

    ``number`` and ``text``: of the statement, whatever the cycle. ``parameters``: must vary.
    ``margins`` (model, cycle, variable); ``finds`` (studies, rock, cycle, variable), a boolean
    for each study (R,). ``above``: of all margins where it is true. ``alike``: largest
    difference that is none, for comparisons; a statement that is no comparison is false below
    ``above``. ``within``: true where all margins lie within +-``above``, and not above it.
    ``before``: it compares with the cycle before. ``of_elasticities``: these alone decide it.
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

    def cycles(self, cycle: int) -> tuple[int, ...]:
        """Cycles that it needs."""
        return (cycle - 1, cycle) if self.before else (cycle,)

    def least(self, model: Elastic, cycle: int, variable: str = TARGET) -> np.ndarray:
        """The smallest of its margins."""
        return np.min(list(self.margins(model, cycle, variable).values()), axis=0)

    def least_interval(self, intervals: list[Interval]) -> Interval:
        """Confidence interval of the smallest margin (``within``: of what is left to the bound)
        from those of all margins, which hold together."""
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
        """Smallest margin from which it is true."""
        return 0.0 if self.within else self.above


def _size(model: Elastic, parameter: str, cycle: int, variable: str) -> np.ndarray:
    return np.abs(model.elasticity(parameter, cycle, variable))


def _less(first: str, second: str) -> str:
    return f"|e({SYMBOLS[first]})| - |e({SYMBOLS[second]})|"


def _ranked(number: str, text: str, pairs: list[tuple[str, str]], finds: Callable) -> Statement:
    """The closure is more sensitive to the first than to the second of each pair."""

    def margins(model: Elastic, cycle: int, variable: str) -> Margins:
        size = {each: _size(model, each, cycle, variable) for each in PROPERTIES}
        return {_less(one, other): size[one] - size[other] for one, other in pairs}

    def found(studies: Findings, rock: str, cycle: int, variable: str) -> np.ndarray:
        return finds(studies.percents(rock, cycle, variable))

    return Statement(number, text, PROPERTIES, margins, found, alike=TOLERANCE)


def _with_the_cycle(number: str, text: str, parameter: str, sign: int) -> Statement:
    """Sensitivity to a parameter rises (sign 1) or falls (-1) from the cycle before."""

    def margins(model: Elastic, cycle: int, variable: str) -> Margins:
        before, here = (_size(model, parameter, c, variable) for c in (cycle - 1, cycle))
        of = f"|e({SYMBOLS[parameter]})| of cycle"
        pair = (cycle, cycle - 1) if sign > 0 else (cycle - 1, cycle)
        return {f"{of} {pair[0]} - {pair[1]}": sign * (here - before)}

    def found(studies: Findings, rock: str, cycle: int, variable: str) -> np.ndarray:
        before, here = (studies.lengths(rock, parameter, c, variable) for c in (cycle - 1, cycle))
        return here < before if sign > 0 else here > before

    return Statement(number, text, (parameter,), margins, found, alike=TOLERANCE, before=True)


def _trend(number: str, text: str, parameter: str, sign: int) -> Statement:
    """The closure rises (sign 1) or falls (-1) with a parameter, from each level to the next."""
    word = "rise" if sign > 0 else "fall"

    def margins(model: Elastic, cycle: int, variable: str) -> Margins:
        name = f"{word} with {SYMBOLS[parameter]}"
        slopes = model.slopes(parameter, cycle, variable)
        return {f"{name}, step {i + 1}": sign * slope for i, slope in enumerate(slopes)}

    def found(studies: Findings, rock: str, cycle: int, variable: str) -> np.ndarray:
        return monotone(studies.means(rock, parameter, variable, cycle), sign)

    return Statement(number, text, (parameter,), margins, found)


def _no_effect(number: str, text: str, parameter: str, change: float) -> Statement:
    """A change of a parameter by so much changes the closure by a negligible part."""

    def margins(model: Closed, cycle: int, variable: str) -> Margins:
        return {
            f"change with {SYMBOLS[parameter]} {by:+g}": model.change(parameter, cycle, by)
            for by in (-change, change)
        }

    def found(studies: Findings, rock: str, cycle: int, variable: str) -> np.ndarray:
        return studies.lengths(rock, parameter, cycle, variable) >= change

    return Statement(
        number, text, (parameter,), margins, found, NEGLIGIBLE, within=True, of_elasticities=False
    )


def _significant(number: str, text: str, parameter: str, percent: float) -> Statement:
    """A study of the paper's size finds a change of a parameter by so much significant."""
    name = f"change with {percent:g} % of {SYMBOLS[parameter]}, over a significant one"

    def margins(model: Closed, cycle: int, variable: str) -> Margins:
        change = 0.01 * percent * np.abs(model.elasticity(parameter, cycle, variable))
        return {name: change / model.significant(cycle)}

    def found(studies: Findings, rock: str, cycle: int, variable: str) -> np.ndarray:
        return studies.percents(rock, cycle, variable)[parameter] <= percent

    return Statement(number, text, (parameter,), margins, found, 1.0, of_elasticities=False)


def _loop(number: str, text: str) -> Statement:
    """Unloading lies above loading."""

    def margins(model: Closed, cycle: int, variable: str) -> Margins:
        return {"loop over closure": model.loop(cycle)}

    def found(studies: Findings, rock: str, cycle: int, variable: str) -> np.ndarray:
        return studies.base_means(rock, LOOP, cycle) > 0.0

    return Statement(number, text, (), margins, found, NEGLIGIBLE, of_elasticities=False)


NU_LEAST = _ranked(
    "1a",
    "Poisson's ratio matters least",
    [(each, NU) for each in (E, STRENGTH, JRC)],
    lambda percents: widest(percents, NU),
)
NU_NO_EFFECT = _no_effect("1b", "No effect of a change of Poisson's ratio by 0.1", NU, 0.1)
E_MOST = _ranked(
    "2a",
    "Young's modulus matters most",
    [(E, each) for each in (NU, STRENGTH, JRC)],
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
HYSTERESIS = _loop("6a", "Unloading shows hysteresis")

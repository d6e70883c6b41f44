"""The paper's claims, with criteria for their truth in the model, and for confirmation by a study.

Criteria for confirmation are evaluated for R studies (repetitions) at once; a real study has R = 1.
"""

from collections.abc import Callable, Mapping
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from jointclosure import parameters
from jointclosure.statistics.quadratics import smoothed_by_all_levels
from jointclosure.statistics.repetitions import DrawnResponse
from jointclosure.statistics.standard_errors import Limits
from jointclosure.statistics.verdicts import FALLS, STANDS, verdict

TARGET, NET = "max_closure", "max_closure_net"
"""Names of the maximum closure, and of the maximum closure net of bulk indentation."""
LOOP = "loop"
"""Name of the loop: closure on unloading less closure on loading, at half the maximum stress."""
EXCESS = "excess"
"""Name of the excess at low stress: the closure on loading at half the maximum stress, since the
start of the cycle, less half of the maximum closure."""

FOUND = ("found_share", "found_error", "found_low", "found_high")
"""Columns of the share of studies that confirm a claim: share, standard error, 95 % interval."""


class Findings(NamedTuple):
    """Results of R studies, by which claims are confirmed or not."""

    drawn: dict[tuple[str, str], DrawnResponse]  # by rock and parameter
    names: tuple[tuple[str, int], ...]  # variable and cycle of the targets of each response

    def rocks(self, parameters: tuple[str, ...]) -> list[str]:
        """Return the rocks for which all these parameters are varied, in order."""
        rocks = dict.fromkeys(rock for rock, _ in self.drawn)
        return [rock for rock in rocks if all((rock, one) in self.drawn for one in parameters)]

    def percents(self, rock: str, cycle: int, variable: str) -> dict[str, np.ndarray]:
        """Return lengths (R,) of indifference intervals [% of the rock's value], by parameter.

        They are infinite without a root. Parameters whose value is 0 in the rock are left out.
        """
        return {
            parameter: 100.0 * self.lengths(parameter, rock, cycle, variable) / abs(response.base)
            for (name, parameter), response in self.drawn.items()
            if name == rock and response.base != 0.0
        }

    def lengths(self, parameter: str, rock: str, cycle: int, variable: str) -> np.ndarray:
        """Return the lengths (R,) [SI] of an indifference interval."""
        return self.drawn[rock, parameter].lengths[:, self.names.index((variable, cycle))]

    def means(self, parameter: str, rock: str, cycle: int, variable: str) -> np.ndarray:
        """Return the mean closures (R, levels) [m] at the levels of a parameter."""
        return self.drawn[rock, parameter].means[:, self.names.index((variable, cycle))]

    def smoothed(self, parameter: str, rock: str, cycle: int, variable: str) -> np.ndarray:
        """Return mean closures (R, 3) [m] at three levels, see `smoothed_by_all_levels`."""
        levels, base, *_ = self.drawn[rock, parameter]
        means = self.means(parameter, rock, cycle, variable)
        return smoothed_by_all_levels(levels, means, base)[1]

    def base_means(self, rock: str, cycle: int, variable: str) -> np.ndarray:
        """Return the mean closures (R,) [m] of the base case of a rock."""
        parameter = next(parameter for name, parameter in self.drawn if name == rock)
        levels, base, *_ = self.drawn[rock, parameter]
        at_base = int(np.flatnonzero(levels == base)[0])
        return self.means(parameter, rock, cycle, variable)[:, at_base]


NU, E, STRENGTH, JRC = "poisson_ratio", "youngs_modulus", "compressive_strength", "jrc"
PROPERTIES = (NU, E, STRENGTH, JRC)
"""Properties that the claims of the paper concern."""
SYMBOLS = {name: parameters.PROPERTIES[name].symbol for name in PROPERTIES}

NEGLIGIBLE = 0.02
"""Largest relative change of a closure that counts as none. It is the tolerance at which `effects:
auto` leaves an effect out, and less than the difference of repeated measurements of a closure."""
TOLERANCE = NEGLIGIBLE / 0.2
"""Largest difference of elasticities that counts as none. A property of a rock is known to a fifth
at best; with such a difference, a change by a fifth changes the closure by `NEGLIGIBLE` or less."""


class Elasticities(NamedTuple):
    """Model of a rock that consists of the elasticities of one variable by parameter and cycle.

    It has the methods of `studies.paper.judged_claims.ClosedModel` that statements with
    ``of_elasticities`` need. ``bases`` are the rock's values of the parameters [SI].
    """

    by_cycle: Mapping[tuple[str, int], Any]
    bases: Mapping[str, float]

    def elasticity(self, parameter: str, cycle: int, variable: str) -> Any:
        """Return d ln(closure)/d ln(parameter) at the rock's value."""
        return self.by_cycle[parameter, cycle]

    def slopes(self, parameter: str, cycle: int, variable: str) -> list:
        """Return a list with the elasticity, in place of those of both halves of the levels."""
        return [self.by_cycle[parameter, cycle]]

    def change(self, parameter: str, cycle: int, change: float) -> Any:
        """Return the relative change of closure with a change [SI] of a parameter: power law."""
        return (1.0 + change / self.bases[parameter]) ** self.by_cycle[parameter, cycle] - 1.0


class ClosureStatement(NamedTuple):
    """Statement on the closure of a cycle in one rock, with criteria for its truth.

    ``margins`` is a function that returns numbers by name, from a model, the cycle and the variable
    of the closure. The statement is true of the model if all margins exceed ``above``, or, if
    ``within`` is set, if the sizes of all margins are below ``above``. ``finds`` is a function that
    returns whether each of R studies confirms the statement, from `Findings`, rock, cycle and
    variable. ``parameter`` is the subject of the statement, and ``parameters`` are all that must be
    varied. ``alike`` is the largest size of a margin that counts as no difference; None: every
    difference counts. If ``before`` is set, the statement compares the cycle with the one before.
    If ``of_elasticities`` is set, margins need only `Elasticities` as a model.
    """

    number: str
    text: str
    parameter: str
    parameters: tuple[str, ...]
    margins: Callable[[Any, int, str], Mapping[str, Any]]
    finds: Callable[[Findings, str, int, str], np.ndarray]
    above: float = TOLERANCE
    alike: float | None = None
    within: bool = False
    before: bool = False
    of_elasticities: bool = True

    def cycles(self, cycle: int) -> tuple[int, ...]:
        """Return the cycles that the statement needs."""
        return (cycle - 1, cycle) if self.before else (cycle,)

    def least(self, model: Any, cycle: int, variable: str = TARGET) -> np.ndarray:
        """Return the smallest margin of a model; if ``within``, the least distance to the bound.

        The statement is true if this exceeds `true_above`.
        """
        margins = list(self.margins(model, cycle, variable).values())
        if self.within:
            return self.above - np.max(np.abs(margins), axis=0)
        return np.min(margins, axis=0)

    def least_limits(self, intervals: list[Limits]) -> Limits:
        """Return the interval of `least` from the simultaneous intervals of all margins."""
        if self.within:
            intervals = [
                Limits(self.above - max(abs(low), abs(high)), self.above - max(low, -high, 0.0))
                for low, high in intervals
            ]
        return Limits(*(min(ends) for ends in zip(*intervals, strict=True)))

    def true_above(self) -> float:
        """Return the bound that `least` must exceed for the statement to be true."""
        return 0.0 if self.within else self.above


def _shortest(percents: dict[str, np.ndarray], parameter: str, place: int = 0) -> np.ndarray:
    """Return which studies (R,) have exactly ``place`` intervals shorter than a parameter's own.

    The length of the parameter's own interval must also be finite. ``percents`` are lengths (R,) by
    parameter.
    """
    shorter = (np.array(list(percents.values())) < percents[parameter]).sum(axis=0)
    return (shorter == place) & np.isfinite(percents[parameter])


def _widest(percents: dict[str, np.ndarray], parameter: str) -> np.ndarray:
    """Return which studies (R,) have no interval longer than a parameter's own, and a finite one.

    ``percents`` are lengths (R,) by parameter.
    """
    every = np.array(list(percents.values()))
    return (percents[parameter] >= every.max(axis=0)) & np.isfinite(every).any(axis=0)


def _ranked(
    number: str, text: str, parameter: str, finds: Callable, *pairs: tuple[str, str]
) -> ClosureStatement:
    """Return the statement that closure is more sensitive to one property than to another.

    It is made for each of the ``pairs``, in which the property with the larger sensitivity is
    first. ``finds`` tells which studies confirm the statement, from the lengths [%] of indifference
    intervals and the ``parameter``.
    """

    def margins(model: Any, *at: Any) -> dict[str, Any]:
        size = {name: np.abs(model.elasticity(name, *at)) for name in PROPERTIES}
        return {
            f"|e({SYMBOLS[one]})| - |e({SYMBOLS[other]})|": size[one] - size[other]
            for one, other in pairs
        }

    def confirms(studies: Findings, *at: Any) -> np.ndarray:
        return finds(studies.percents(*at), parameter)

    return ClosureStatement(number, text, parameter, PROPERTIES, margins, confirms, alike=TOLERANCE)


def _with_the_cycle(number: str, text: str, parameter: str, sign: int) -> ClosureStatement:
    """Return the statement that the sensitivity of closure to a parameter changes with the cycle.

    From the cycle before it rises (``sign`` 1) or falls (-1).
    """

    def margins(model: Any, cycle: int, variable: str) -> dict[str, Any]:
        before, here = (
            np.abs(model.elasticity(parameter, c, variable)) for c in (cycle - 1, cycle)
        )
        more, less = (cycle, cycle - 1)[::sign]
        return {f"|e({SYMBOLS[parameter]})| of cycle {more} - {less}": sign * (here - before)}

    def confirms(studies: Findings, rock: str, cycle: int, variable: str) -> np.ndarray:
        before, here = (studies.lengths(parameter, rock, c, variable) for c in (cycle - 1, cycle))
        return sign * here < sign * before

    about = number, text, parameter, (parameter,)
    return ClosureStatement(*about, margins, confirms, alike=TOLERANCE, before=True)


def _trend(number: str, text: str, parameter: str, sign: int) -> ClosureStatement:
    """Return the statement that closure rises (``sign`` 1) or falls (-1) with a parameter.

    It is judged in both halves of the parameter's range, by a quadratic fitted to all levels.
    """
    name = f"{'rise' if sign > 0 else 'fall'} with {SYMBOLS[parameter]}"
    return ClosureStatement(
        number, text, parameter, (parameter,),
        lambda model, *at: {
            f"{name}, {half} half of the levels": sign * slope
            for half, slope in zip(
                ("lower", "upper"), model.slopes(parameter, *at), strict=False
            )
        },
        lambda studies, *at: np.all(
            sign * np.diff(studies.smoothed(parameter, *at), axis=1) > 0.0, axis=1
        ),
    )  # fmt: skip


def _positive(number: str, text: str, reads: str) -> ClosureStatement:
    """Return the statement that `LOOP` or `EXCESS` (``reads``) of the base case is positive."""
    return ClosureStatement(
        number, text, "", (),
        lambda model, cycle, _: {f"{reads} over closure": model.share(reads, cycle)},
        lambda studies, rock, cycle, _: studies.base_means(rock, cycle, reads) > 0.0,
        NEGLIGIBLE, of_elasticities=False,
    )  # fmt: skip


NU_LEAST = _ranked(
    "1a", "Poisson's ratio matters least", NU, _widest, (E, NU), (STRENGTH, NU), (JRC, NU)
)
NU_NO_EFFECT = ClosureStatement(
    "1b", "No effect of a change of Poisson's ratio by 0.1", NU, (NU,),
    lambda model, cycle, _: {
        f"change with {SYMBOLS[NU]} {by:+g}": model.change(NU, cycle, by) for by in (-0.1, 0.1)
    },
    lambda studies, *at: studies.lengths(NU, *at) >= 0.1,
    NEGLIGIBLE, within=True,
)  # fmt: skip
E_MOST = _ranked(
    "2a", "Young's modulus matters most", E, _shortest, (E, NU), (E, STRENGTH), (E, JRC)
)
E_RISES = _with_the_cycle("2c", "Young's modulus matters more than on the cycle before", E, 1)
STRENGTH_NEXT = _ranked(
    "3", "Compressive strength matters next after Young's modulus", STRENGTH,
    partial(_shortest, place=1), (E, STRENGTH), (STRENGTH, NU), (STRENGTH, JRC),
)  # fmt: skip
STRENGTH_RISES = _with_the_cycle(
    "3b", "Compressive strength matters more than on the cycle before", STRENGTH, 1
)
STRENGTH_SIGNIFICANT = ClosureStatement(
    "3c", "A change of compressive strength by 5 % is significant", STRENGTH, (STRENGTH,),
    lambda model, cycle, variable: {
        f"change with 5 % of {SYMBOLS[STRENGTH]}, over a significant one": 0.05
        * np.abs(model.elasticity(STRENGTH, cycle, variable)) / model.significant(cycle)
    },
    lambda studies, *at: studies.percents(*at)[STRENGTH] <= 5.0,
    1.0, of_elasticities=False,
)  # fmt: skip
JRC_FALLS = _with_the_cycle("4", "JRC matters less than on the cycle before", JRC, -1)
FALLS_WITH_E = _trend("5a", "Closure rises when E falls", E, -1)
RISES_WITH_STRENGTH = _trend("5b", "Closure rises when sigma_c rises", STRENGTH, 1)
RISES_WITH_JRC = _trend("5c", "Closure falls when JRC falls", JRC, 1)
HYSTERESIS = _positive("6a", "Unloading shows hysteresis", LOOP)
SOFT_AT_FIRST = _positive("6b", "Low stresses close more than high ones", EXCESS)

UNJUDGED = _positive("8", "No sensitivity study can judge it", "")
"""Statement of claims that no study can judge; its margins are never computed."""

OURS = "ours"
"""Section of a claim that is not in the paper, but is a variant that this study adds."""
TABLE_3 = "table 3"
"""Where the paper shows a claim: by the entries of Table 3."""


class Claim(NamedTuple):
    """Claim of the paper: a statement on some cycles, for gross or net closures (``variable``).

    ``section`` is that of the paper, or `OURS`. The statement is `UNJUDGED` if no sensitivity study
    can judge it. ``shown`` is where the paper has numbers: `TABLE_3` for the entries of the
    statement's parameter. If ``negated`` is set, the claim is that the statement is *not* true in
    every rock.
    """

    number: str
    text: str
    section: str
    statement: ClosureStatement
    cycles: tuple[int, ...]
    shown: str = TABLE_3
    variable: str = TARGET
    negated: bool = False
    remark: str = ""

    def verdict(self, least: tuple[float, float]) -> str:
        """Return the verdict on the claim in the model, from the interval of the smallest margin.

        ``least`` is this confidence interval (low, high) over all rocks and cycles.
        """
        word = verdict(least, self.statement.true_above(), self.statement.alike)
        return {STANDS: FALLS, FALLS: STANDS}.get(word, word) if self.negated else word

    def cycles_among(self, names: tuple[tuple[str, int], ...]) -> list[int]:
        """Return those cycles of the claim for which all targets exist that the statement needs.

        ``names`` are the targets (variable, cycle) that exist.
        """
        cycles = {cycle for variable, cycle in names if variable == self.variable}
        return [c for c in self.cycles if cycles.issuperset(self.statement.cycles(c))]

    def found_in(self, studies: Findings) -> np.ndarray | None:
        """Return which studies (R,) confirm the claim; None if no rock or cycle can be judged.

        A study confirms a claim if it finds the statement true in every rock and cycle. It confirms
        a negated claim if it does not.
        """
        cycles = self.cycles_among(studies.names)
        if not cycles or not (rocks := studies.rocks(self.statement.parameters)):
            return None
        at = ((studies, rock, cycle, self.variable) for rock in rocks for cycle in cycles)
        every = np.logical_and.reduce([self.statement.finds(*one) for one in at])
        return ~every if self.negated else every


HERTZ_EXCESS = 0.5 ** (2.0 / 3.0) - 0.5
"""Excess at half the stress over the closure of one Hertz contact, Eq. (5)."""

_BOTH = "Sections 6, 7"
_MOST = "Abstract, Sections 1, 6, 7"
_NEXT = "Abstract, Section 6"
_NOT_SHOWN = "described, not shown"
_FIG_5 = "Fig. 5"

CLAIMS = (
    Claim("1a, cycle 1", "Poisson's ratio matters least on the first cycle", _BOTH, NU_LEAST, (1,)),
    Claim("1a, cycle 2", "Poisson's ratio matters least on the second cycle", _BOTH,
          NU_LEAST, (2,)),
    Claim("1b", "No effect of a change of Poisson's ratio by ±0.1", _NEXT, NU_NO_EFFECT, (1, 2)),
    Claim("2a", "Young's modulus is the most sensitive parameter on the second cycle", _MOST,
          E_MOST, (2,)),
    Claim("2a, net", "Young's modulus is the most sensitive parameter on the second cycle, net of "
          "bulk indentation", OURS, E_MOST, (2,), variable=NET),
    Claim("2b", "Young's modulus is the most sensitive parameter on the first cycle", _MOST, E_MOST,
          (1,)),
    Claim("2c", "Sensitivity to Young's modulus rises from the first cycle to the second",
          "Section 6", E_RISES, (2,)),
    Claim("3, cycle 1", "Compressive strength is the next sensitive parameter on the first cycle",
          _NEXT, STRENGTH_NEXT, (1,)),
    Claim("3, cycle 2", "Compressive strength is the next sensitive parameter on the second cycle",
          _NEXT, STRENGTH_NEXT, (2,)),
    Claim("3b", "Sensitivity to compressive strength rises from the first cycle to the second",
          "Section 6", STRENGTH_RISES, (2,)),
    Claim("3c", "A change of compressive strength by 5 % is significant on the second cycle",
          "Section 6", STRENGTH_SIGNIFICANT, (2,)),
    Claim("4", "Sensitivity to JRC falls from the first cycle to the second", _NEXT,
          JRC_FALLS, (2,)),
    Claim("5a", "Cycle-2 closure rises when E falls", _BOTH, FALLS_WITH_E, (2,), _NOT_SHOWN),
    Claim("5a, net", "Cycle-2 closure rises when E falls, net of bulk indentation", OURS,
          FALLS_WITH_E, (2,), _NOT_SHOWN, variable=NET),
    Claim("5b", "Cycle-2 closure rises when sigma_c rises", _BOTH, RISES_WITH_STRENGTH, (2,),
          _NOT_SHOWN),
    Claim("5c", "Cycle-1 closure falls when JRC falls", "Section 6", RISES_WITH_JRC, (1,),
          _NOT_SHOWN),
    Claim("5d", "In at least one rock cycle-2 closure does not fall when JRC falls", "Section 6",
          RISES_WITH_JRC, (2,), _NOT_SHOWN, negated=True),
    Claim("6a", "Unloading shows hysteresis on both cycles", "Abstract, Section 5",
          HYSTERESIS, (1, 2), _FIG_5, remark="by construction: an unloading that broke "
          "nothing is the curve of the next loading, so cycle 2 has no loop"),
    Claim("6b", "Excess deformation at low stress survives on the second cycle", "Sections 3, 5",
          SOFT_AT_FIRST, (2,), _FIG_5, remark="by construction of a stiffening contact, "
          f"{HERTZ_EXCESS:.2f} of the closure for Hertz's; the measured curves are not available"),
    Claim("8", "The model fits Bandis' curves, dolerite worst, second cycles worse", "Section 5",
          UNJUDGED, (), _FIG_5, remark="the measured curves are not available"),
)  # fmt: skip
"""All claims, in the order in which they are shown."""


def statements_of_elasticities() -> list[ClosureStatement]:
    """Return the distinct statements that depend only on elasticities."""
    by_number = {claim.statement.number: claim.statement for claim in CLAIMS}
    return [statement for statement in by_number.values() if statement.of_elasticities]

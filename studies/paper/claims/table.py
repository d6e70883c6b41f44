"""Claims of Rezaei Niya & Selvadurai, in one table that all studies use.

The paper is "Modeling the Approach of Non-mated Rock Fracture Surfaces Under Quasi-static Normal
Load Cycles".
"""

from typing import NamedTuple

import numpy as np

from jointclosure.statistics.verdicts import FALLS, STANDS, verdict
from studies.paper.claims import statements
from studies.paper.claims.findings import NET, TARGET, Findings
from studies.paper.claims.statements import Closed, Statement, Value

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
        """Statement of the claim.

        Raises
        ------
        ValueError
            If it has none.
        """
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

    def margins(self, model: Closed, cycles: list[int]) -> dict[tuple[str, int], Value]:
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
          statements.NU_LEAST, (1,), parameter="poisson_ratio"),
    Claim("1a, cycle 2", "Poisson's ratio matters least on the second cycle", _BOTH,
          statements.NU_LEAST, (2,), parameter="poisson_ratio"),
    Claim("1b", "No effect of a change of Poisson's ratio by ±0.1", _NEXT,
          statements.NU_NO_EFFECT, (1, 2), parameter="poisson_ratio"),
    Claim("2a", "Young's modulus is the most sensitive parameter on the second cycle", _MOST,
          statements.E_MOST, (2,), parameter="youngs_modulus"),
    Claim("2a, net", "Young's modulus is the most sensitive parameter on the second cycle, net of "
          "bulk indentation", OURS, statements.E_MOST, (2,), parameter="youngs_modulus",
          variable=NET),
    Claim("2b", "Young's modulus is the most sensitive parameter on the first cycle", _MOST,
          statements.E_MOST, (1,), parameter="youngs_modulus"),
    Claim("2c", "Sensitivity to Young's modulus rises from the first cycle to the second",
          "Section 6", statements.E_RISES, (2,), parameter="youngs_modulus"),
    Claim("3, cycle 1", "Compressive strength is the next sensitive parameter on the first cycle",
          _NEXT, statements.STRENGTH_NEXT, (1,), parameter="compressive_strength"),
    Claim("3, cycle 2", "Compressive strength is the next sensitive parameter on the second cycle",
          _NEXT, statements.STRENGTH_NEXT, (2,), parameter="compressive_strength"),
    Claim("3b", "Sensitivity to compressive strength rises from the first cycle to the second",
          "Section 6", statements.STRENGTH_RISES, (2,), parameter="compressive_strength"),
    Claim("3c", "A change of compressive strength by 5 % is significant on the second cycle",
          "Section 6", statements.STRENGTH_SIGNIFICANT, (2,), parameter="compressive_strength"),
    Claim("4", "Sensitivity to JRC falls from the first cycle to the second", _NEXT,
          statements.JRC_FALLS, (2,), parameter="jrc"),
    Claim("5a", "Cycle-2 closure rises when E falls", _BOTH, statements.FALLS_WITH_E, (2,),
          _NOT_SHOWN),
    Claim("5a, net", "Cycle-2 closure rises when E falls, net of bulk indentation", OURS,
          statements.FALLS_WITH_E, (2,), _NOT_SHOWN, variable=NET),
    Claim("5b", "Cycle-2 closure rises when sigma_c rises", _BOTH,
          statements.RISES_WITH_STRENGTH, (2,), _NOT_SHOWN),
    Claim("5c", "Cycle-1 closure falls when JRC falls", "Section 6", statements.RISES_WITH_JRC,
          (1,), _NOT_SHOWN),
    Claim("5d", "Cycle-2 closure has no such trend with JRC in every rock", "Section 6",
          statements.RISES_WITH_JRC, (2,), _NOT_SHOWN, negated=True),
    Claim("6a", "Unloading shows hysteresis on both cycles", "Abstract, Section 5",
          statements.HYSTERESIS, (1, 2), _FIG_5, remark="by construction: an unloading that broke "
          "nothing is the curve of the next loading, so cycle 2 has no loop"),
    Claim("6b", "Excess deformation at low stress survives on the second cycle", "Sections 3, 5",
          statements.SOFT_AT_FIRST, (2,), _FIG_5, remark="by construction of a stiffening contact, "
          f"{HERTZ_EXCESS:.2f} of the closure for Hertz's; the measured curves are not available"),
    Claim("8", "The model fits Bandis' curves, dolerite worst, second cycles worse", "Section 5",
          None, (), _FIG_5, remark="the measured curves are not available"),
)  # fmt: skip
"""All claims, in the order in which they are shown."""


def statements_of_elasticities() -> list[Statement]:
    """Return the distinct statements that depend only on elasticities."""
    by_number = {claim.statement.number: claim.statement for claim in CLAIMS if claim.statement}
    return [statement for statement in by_number.values() if statement.of_elasticities]

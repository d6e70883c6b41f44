"""Solvers by name: each inherits every test of the registry.

A solver is imported when it is used, so that a job that only checks a name does not load Numba.
"""

from collections.abc import Callable
from typing import TYPE_CHECKING

from jointclosure.inputs import InputError
from jointclosure.parameters import SOLVER_NAMES

if TYPE_CHECKING:
    from jointclosure.solvers.joint import Solver


def _fast() -> "Solver":
    from jointclosure.solvers.fast import FastSolver

    return FastSolver()


def _reference() -> "Solver":
    from jointclosure.solvers.reference import ReferenceSolver

    return ReferenceSolver()


SOLVERS: dict[str, "Callable[[], Solver]"] = dict(
    zip(SOLVER_NAMES, (_fast, _reference), strict=True)
)


def solver_named(name: str) -> "Solver":
    """Return a solver by its name; `InputError` lists the names."""
    if name not in SOLVERS:
        raise InputError(f"solver = {name!r}: must be one of {', '.join(SOLVERS)}")
    return SOLVERS[name]()

"""Solvers by name, imported when used: a job that only checks a name does not load Numba."""

from typing import TYPE_CHECKING

from jointclosure.inputs import check_one_of
from jointclosure.parameters import SOLVER_NAMES

if TYPE_CHECKING:
    from jointclosure.solvers.joint import Solver


def solver_named(name: str) -> "Solver":
    """Return a solver by its name, "fast" or "reference".

    Raise `InputError`, which lists the names, for any other name.
    """
    check_one_of("solver", name, SOLVER_NAMES)
    if name == "reference":
        from jointclosure.solvers.reference import ReferenceSolver

        return ReferenceSolver()
    from jointclosure.solvers.fast import FastSolver

    return FastSolver()

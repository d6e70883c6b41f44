"""The solvers there are, by name: each inherits every test of the registry.

A solver is imported when it is asked for, so that a job which only checks a name
does not load Numba.
"""

from collections.abc import Callable
from typing import TYPE_CHECKING

from jointclosure.inputs import InputError

if TYPE_CHECKING:
    from jointclosure.solvers.joint import Solver


def _fast() -> "Solver":
    from jointclosure.solvers.fast import FastSolver

    return FastSolver()


def _reference() -> "Solver":
    from jointclosure.solvers.reference import ReferenceSolver

    return ReferenceSolver()


SOLVERS: dict[str, "Callable[[], Solver]"] = {"fast": _fast, "reference": _reference}


def solver_named(name: str) -> "Solver":
    """A solver by its name; `InputError` names those there are."""
    if name not in SOLVERS:
        raise InputError(f"solver = {name!r}: must be one of {', '.join(SOLVERS)}")
    return SOLVERS[name]()

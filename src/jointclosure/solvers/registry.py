"""The solvers there are, by name: each inherits every test of the registry."""

from jointclosure.inputs import InputError
from jointclosure.solvers.fast import FastSolver
from jointclosure.solvers.joint import Solver
from jointclosure.solvers.reference import ReferenceSolver

SOLVERS: dict[str, type] = {"fast": FastSolver, "reference": ReferenceSolver}


def solver_named(name: str) -> Solver:
    """A solver by its name; `InputError` names those there are."""
    if name not in SOLVERS:
        raise InputError(f"solver = {name!r}: must be one of {', '.join(SOLVERS)}")
    return SOLVERS[name]()

"""Limits of the numbers by which the oracle judges a joint, and the largest ratio to its limit."""

import math
from collections.abc import Mapping

import numpy as np

from jointclosure import oracle
from jointclosure.ensembles.simulated_joint import SimulatedJoint
from jointclosure.joint.simulation import height_datum
from jointclosure.joint.status import LOADING
from jointclosure.solvers.elastic import ELASTIC_TOLERANCE
from jointclosure.solvers.fast import BAND
from jointclosure.solvers.registry import solver_named

VOLUME_TOLERANCE = LOAD_TOLERANCE = 1e-12
STRENGTH_TOLERANCE = 1e-6  # of a contact at rest, due to the last change of the interaction
ROUNDINGS = 16.0  # allowed error of an overlap, in units in the last place of the heights
MOST_CONTACTS = 20_000  # cells in contact above which the dense oracle judges no snapshot
SOLVED = 1.01  # allowed residual over the tolerance of a solver, which sums it in another order


def limits_of(verdict, effects, tolerances: dict[str, float]) -> dict[str, float]:
    """Return the limits of the numbers of an `oracle.Verdict`, by name.

    Numbers that are not among them must be 0. The limit of a number that is only reported is
    infinite. Limits of forces contain the error of the solver, in ``tolerances`` as from
    `tolerances_of`, and that of the last digits of the heights. ``effects`` are those of the
    simulation.
    """
    digits = ROUNDINGS * verdict.rounding
    solved = SOLVED * tolerances["residual"] + digits
    lost = effects.breakage and not effects.gouge
    return {
        "residual": solved,
        "without_overlap": solved,
        "without_force": solved,
        "rounding": np.inf,
        "load": LOAD_TOLERANCE,
        "volume": np.inf if lost else VOLUME_TOLERANCE if effects.breakage else 0.0,
        "strength": STRENGTH_TOLERANCE + tolerances["strength"] + digits,
    }


def tolerances_of(effects, numerics, by_stress: bool = True) -> dict[str, float]:
    """Return the allowed "residual" of equilibrium and excess of "strength" of a simulation [1].

    ``by_stress`` is whether the state was solved for a stress, and not for a closure. Without
    breakage the fast solver is more accurate then.
    """
    residual = numerics.force_tolerance
    if by_stress and not effects.breakage and solver_named(numerics.solver).elastic_curve:
        residual = min(residual, ELASTIC_TOLERANCE)
    resolved = numerics.breakage == "resolved"
    return {"residual": residual, "strength": 0.5 * BAND * numerics.tolerance if resolved else 0.0}


def largest_ratio(numbers: Mapping[str, float], limits: Mapping[str, float]) -> float:
    """Return the largest ratio of the ``numbers`` to their ``limits``, both by name.

    A number without a limit has the limit 0, and a number above 0 with this limit an infinite
    ratio. Numbers with an infinite limit are left out.
    """
    both = ((value, limits.get(name, 0.0)) for name, value in numbers.items())
    judged = [(value, limit) for value, limit in both if limit < math.inf and (value or limit)]
    return float(np.max([value / limit if limit else math.inf for value, limit in judged]))


def oracle_ratio(joint: SimulatedJoint) -> float:
    """Return the largest ratio of the oracle's numbers to their limits, at the first maximum.

    The joint must have a snapshot at its maximum stress. The ratio is NaN if there is none on a
    loading, as when breakage jumped over the maximum, and for more than `MOST_CONTACTS` cells in
    contact.
    """
    closed = joint.closed
    given = joint.conditions
    loaded = closed.isel(snapshot=closed.snapshot_branch.values == LOADING)
    if not loaded.sizes["snapshot"]:
        return np.nan
    snapshot = loaded.isel(snapshot=0)
    step = int(loaded.snapshot_step[0])
    force = snapshot.snapshot_force.values
    if np.count_nonzero(force) > MOST_CONTACTS:
        return np.nan
    above, below = (height_datum(wall) for wall in joint.walls)  # which the solver takes off
    area = joint.walls[0].size * given.grid_spacing**2
    state = oracle.State(
        snapshot.snapshot_upper.values - above,
        snapshot.snapshot_lower.values - below,
        force,
        float(closed.closure[step]),
        float(closed.normal_stress[step]) * area,
    )
    pristine = oracle.PristineJoint(
        joint.walls[0] - above,
        joint.walls[1] - below,
        given.grid_spacing,
        given.rock,
        given.effects,
        given.choices,
    )
    verdict = oracle.judge(pristine, state)
    tolerances = tolerances_of(given.effects, given.numerics)
    return largest_ratio(verdict._asdict(), limits_of(verdict, given.effects, tolerances))

"""Contact of a half-space whose pressures have a limit: for `continuum.py`.

In each cell of pressure p and gap g (less than 0: overlap), one of three holds: p = 0 and g >= 0;
0 < p < hardness and g = 0; p = hardness and g <= 0. At a given closure that is a linear
complementarity problem with bounds and a positive definite matrix, so there is one solution. It is
found by block principal pivoting (Judice & Pires 1994), which ends: cells that break their
condition change their set all at once, and one at a time where that makes no progress. The closure
follows the stress, which grows with it, by Newton steps between bounds.

The half-space is that of `peers.py`. Overlap at the hardness stays as plastic displacement, as in
ContactMechanics.
"""

from typing import NamedTuple

import numpy as np
import peers
import scipy
from peers import TABLE, displacement

OUTSIDE, FREE, LIMITED = -1, 0, 1
BLOCKS = 10
"""Times that all cells may change at once without progress."""
MOST = 20_000
OVERLAP = 1e-13
"""Of a gap, as 0 [m]."""
STEP = 1e-5
"""At most, of the closure at once [m]."""
LOAD = 1e-10
"""Of the stress, relative."""
PENETRATION = 1e-8
"""Of cells in contact, at which ContactMechanics may stop [m]."""
ITERATIONS = 5000
"""At most, of ContactMechanics."""


class State(NamedTuple):
    """Closure [m], sets (y, x) of the cells, pressures (y, x) [Pa] and gaps (y, x) [m] there."""

    closure: float
    sets: np.ndarray
    pressure: np.ndarray
    gap: np.ndarray


def at_closure(
    heights: np.ndarray, hardness: float, closure: float, sets: np.ndarray
) -> tuple[State, float]:
    """Equilibrium at a closure [m], begun with sets of cells, and its stiffness.

    Parameters
    ----------
    heights : array (y, x)
        Gap of the walls that are not loaded, at closure 0 [m].
    hardness : float
        Largest pressure [Pa].

    Returns
    -------
    State
    float
        Change of the sum of pressures with the closure [Pa/m] by these sets.
    """
    sets, fewest, tries = sets.copy(), sets.size + 1, BLOCKS
    for _ in range(MOST):
        pressure = np.where(sets == LIMITED, hardness, 0.0)
        y, x = free = np.nonzero(sets == FREE)
        stiffness = 0.0
        if y.size:
            factor = scipy.linalg.cho_factor(TABLE[y[:, None] - y, x[:, None] - x])
            overlap = closure - (displacement(pressure) + heights)[free]
            pressure[free] = scipy.linalg.cho_solve(factor, overlap)
            stiffness = float(scipy.linalg.cho_solve(factor, np.ones(y.size)).sum())
        gap = displacement(pressure) + heights - closure
        change = _change(sets, pressure, gap, hardness)
        wrong = np.flatnonzero(change)
        if not wrong.size:
            return State(closure, sets, pressure, gap), stiffness
        tries = BLOCKS if wrong.size < fewest else tries - 1
        fewest = min(fewest, wrong.size)
        moved = wrong if tries >= 0 else wrong[-1:]
        sets.flat[moved] += change.flat[moved]
    raise RuntimeError(f"no equilibrium at a closure of {closure:g} m")


def _change(sets: np.ndarray, pressure: np.ndarray, gap: np.ndarray, hardness: float) -> np.ndarray:
    """To which neighbouring set each cell (y, x) goes: 1 towards the limit, -1 away, 0 stays."""
    free = (pressure > hardness).astype(int) - (pressure < 0.0)
    outside, limited = gap < -OVERLAP, gap > OVERLAP
    return np.where(sets == FREE, free, np.where(sets == OUTSIDE, outside, -1 * limited))


def at_stress(heights: np.ndarray, hardness: float, stress: float, start: State) -> State:
    """Equilibrium at a mean stress [Pa] below the hardness, begun with another equilibrium."""
    closure, sets = start.closure, start.sets
    low, high = -np.inf, np.inf
    for _ in range(MOST):
        state, stiffness = at_closure(heights, hardness, closure, sets)
        missing = stress - float(state.pressure.mean())
        if abs(missing) <= LOAD * stress:
            return state
        low, high = (closure, high) if missing > 0.0 else (low, closure)
        step = missing * heights.size / stiffness if stiffness else np.copysign(STEP, missing)
        closure, sets = closure + float(np.clip(step, -STEP, STEP)), state.sets
        if not low < closure < high:
            closure = 0.5 * (low + high)
    raise RuntimeError(f"no equilibrium at {stress:g} Pa")


def untouched(heights: np.ndarray) -> State:
    """Walls at first touch (`at_closure`), without a load."""
    nothing = np.zeros_like(heights)
    least = float(heights.min())
    return State(least, np.full(heights.shape, OUTSIDE), nothing, heights - least)


def own(gap: np.ndarray, hardness: float):
    """``press`` and ``left`` of `continuum.along` for a gap (y, x) [m], 0 at first touch."""
    heights, state = gap.copy(), untouched(gap)

    def press(stress: float) -> tuple[float, np.ndarray]:
        nonlocal state
        state = at_stress(heights, hardness, stress, state)
        limited = state.sets == LIMITED
        heights[limited] -= state.gap[limited]
        return state.closure, state.pressure

    return press, lambda: float(heights.min())


def contact_mechanics(gap: np.ndarray, hardness: float):
    """The same by ContactMechanics, from no displacement at each stress."""
    from ContactMechanics import FreeFFTElasticHalfSpace
    from ContactMechanics.Factory import make_plastic_system
    from SurfaceTopography import PlasticTopography, Topography

    sizes = (peers.SIDE, peers.SIDE)
    surface = PlasticTopography(Topography(-gap, physical_sizes=sizes), hardness)
    half_space = FreeFFTElasticHalfSpace(gap.shape, peers.MODULUS, sizes)
    system = make_plastic_system(substrate=half_space, surface=surface)

    def press(stress: float) -> tuple[float, np.ndarray]:
        found = system.minimize_proxy(
            external_force=stress * peers.SIDE**2,
            pentol=PENETRATION,
            maxiter=ITERATIONS,
        )
        pressure = found.jac[tuple(slice(cells) for cells in gap.shape)] / peers.CELL
        if not found.success:
            raise RuntimeError(f"ContactMechanics: no equilibrium at {stress:g} Pa")
        return found.offset, pressure

    return press, lambda: float(-surface.heights().max())


CODES = {"own": own, "ContactMechanics": contact_mechanics}

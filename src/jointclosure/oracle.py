"""Oracle: a joint's state recomputed by code that shares nothing with the solvers.

It uses only numpy and scipy, dense and simple, and imports no part of the model (a contract of the
layers checks this). SI units; fields are (y, x). A rock has ``youngs_modulus``,
``poisson_ratio`` and ``compressive_strength``; a joint has one rock, or a pair of (upper, lower).
"""

import math
from typing import Any, NamedTuple

import numpy as np
from scipy.ndimage import maximum_filter, minimum_filter
from scipy.special import hyp2f1

_CHUNK = 500  # rows of the dense influence matrix that are computed at a time
_NEIGHBOURS = np.array([[1, 1, 1], [1, 0, 1], [1, 1, 1]])  # the eight cells around a cell


class PristineJoint(NamedTuple):
    """Joint before any loading: walls (y, x) [m], spacing [m], rock, effects and choices."""

    upper: np.ndarray
    lower: np.ndarray
    spacing: float
    rock: object
    effects: Any
    choices: Any


class State(NamedTuple):
    """State of a joint to be judged: walls [m] and forces [N] (y, x), closure [m], total force [N].

    The total force is the reported one. ``crushed`` (y, x) is a mask of the pairs of cells whose
    rock was crushed before this loading.
    """

    upper: np.ndarray
    lower: np.ndarray
    force: np.ndarray
    closure: float
    total_force: float
    crushed: Any = False


class PairLaw(NamedTuple):
    """Contact law of a joint's pairs of cells, from rocks, peaks, effects and choices.

    ``asperity`` is E_a* of every pair (y, x) [Pa], ``rock_modulus`` 1/(1/E_t* + 1/E_b*) of the
    substrates [Pa]. ``substrate`` is the compliance A of both substrates [m/N], 0 without them.
    ``base_radius`` is in m.
    """

    asperity: np.ndarray
    rock_modulus: float
    substrate: float
    base_radius: float


class Verdict(NamedTuple):
    """Errors of a judged state, all but the first relative; 0 is perfect.

    ``negative_force``: magnitude of the most negative force [N]. ``residual``: sum |F -
    psi(overlap)| / sum F, with the law psi of each contact solved again. ``rounding``: effect of
    one unit in the last place of the heights on this sum. ``without_overlap``: force of cells that
    do not overlap, over the total. ``without_force``: force that unloaded cells with overlap should
    carry, over the total. ``load``: difference of the sum of the forces and the reported total
    force, over the sum. ``volume``: larger change of a wall's volume over sum |z0 - min z0|.
    ``raised``: see `raised`. ``strength``: largest c p0/sigma_c - 1 of a contact that is not
    locked, at least 0. It is computed with the force that the contact's overlap takes, because the
    error of the reported force is in the residual.
    """

    negative_force: float
    residual: float
    rounding: float
    without_overlap: float
    without_force: float
    load: float
    volume: float
    raised: float
    strength: float


def walls_rocks(rock):
    """Return the rocks (upper, lower) of one rock, or of a pair of rocks, which stays as it is."""
    return (rock, rock) if hasattr(rock, "youngs_modulus") else tuple(rock)


def curvature(z, h, largest_radius=None, concave="magnitude"):
    """Compute the inverse Gaussian radius (y, x) [1/m] of heights ``z`` (y, x) [m].

    It is the root of the product of the curvatures of both profiles at the spacing ``h`` [m]. The
    curvature of a profile is that of the circle through three points; heights are mirrored at
    edges. ``largest_radius`` [m] bounds the Gaussian radius. With ``concave`` other than
    "magnitude" concave profiles count as straight.
    """
    padded = np.pad(z, 1, mode="reflect")

    def circle(before, here, after):
        a = np.hypot(h, here - before)
        b = np.hypot(h, after - here)
        c = np.hypot(2 * h, after - before)
        side = (before - here) + (after - here)
        size = np.abs(side) if concave == "magnitude" else np.maximum(-side, 0.0)
        area = 0.5 * h * size
        return 4 * area / (a * b * c)

    x = circle(padded[1:-1, :-2], z, padded[1:-1, 2:])
    y = circle(padded[:-2, 1:-1], z, padded[2:, 1:-1])
    return np.maximum(np.sqrt(x * y), 1.0 / largest_radius if largest_radius else 0.0)


def peaks(z):
    """Return a mask (y, x) of the cells of a wall that are strictly higher than all neighbours."""
    around = maximum_filter(z, footprint=_NEIGHBOURS, mode="constant", cval=-np.inf)
    return z > around


def moduli(rock, peak_modulus_ratio, upper_peaks, lower_peaks):
    """Compute E_a* [Pa] of every pair (y, x), and 1/(1/E_t* + 1/E_b*) [Pa], for the oracle.

    ``upper_peaks`` and ``lower_peaks`` are masks (y, x) of the cells whose modulus is multiplied by
    ``peak_modulus_ratio``.
    """
    above, below = (r.youngs_modulus / (1 - r.poisson_ratio**2) for r in walls_rocks(rock))
    upper = np.where(upper_peaks, peak_modulus_ratio, 1.0) * above
    lower = np.where(lower_peaks, peak_modulus_ratio, 1.0) * below
    return 1 / (1 / upper + 1 / lower), 1 / (1 / above + 1 / below)


def influence(shape, h, r, modulus):
    """Compute the displacement per unit force [m/N] at offsets (y, x) in cells, Eqs. (17) to (20).

    It is 0 at offset (0, 0). Spacing ``h`` and base radius ``r`` are in m, the modulus in Pa. Up to
    ten base radii the printed form is used. Beyond, where the printed form loses its digits, it is
    replaced by its hypergeometric series.
    """
    y, x = np.indices(shape)
    zeta = h * np.hypot(y, x)
    zeta[0, 0] = np.inf
    near = zeta <= 10 * r
    factor = hyp2f1(0.5, 0.5, 2.5, (r / zeta) ** 2)
    table = factor / (np.pi * modulus * zeta)
    z = zeta[near]
    bracket = (2 * r**2 - z**2) * np.arcsin(r / z) + r * np.sqrt(z**2 - r**2)
    table[near] = 3 / (2 * np.pi * r**2) / (2 * modulus * r) * bracket
    return table


def interaction(force, h, r, modulus, at=None):
    """Compute the displacements [m] of cells by the forces (y, x) [N] of all other cells.

    They are (n,) at the cells of flat indices ``at`` (n,), or by default (y, x) at all cells.
    ``h``, ``r`` and ``modulus`` are as for `influence`.
    """
    nx = force.shape[1]
    table = influence(force.shape, h, r, modulus)
    loaded = np.flatnonzero(force)
    cells = np.arange(force.size) if at is None else at
    u = np.empty(cells.size)
    for start in range(0, cells.size, _CHUNK):
        some = cells[start : start + _CHUNK, None]
        matrix = table[np.abs(some // nx - loaded // nx), np.abs(some % nx - loaded % nx)]
        u[start : start + _CHUNK] = matrix @ force.ravel()[loaded]
    return u.reshape(force.shape) if at is None else u


def locked(upper, lower, tolerance=1e-11):
    """Return a mask (y, x) of the pairs of which neither wall's cell has a lower neighbour.

    A neighbour is lower if it is so by more than the ``tolerance`` [m].
    """

    def no_lower(z):
        around = minimum_filter(z, footprint=_NEIGHBOURS, mode="constant", cval=np.inf)
        return z - around <= tolerance

    return no_lower(upper) & no_lower(lower)


def forces_of_overlaps(overlap, compliance, substrate):
    """Compute forces (n,) [N] of contacts A F + B F^(2/3) = overlap >= 0 by bisection of F^(1/3).

    ``compliance`` B (n,) [m N^(-2/3)], ``substrate`` A [m/N]; forces are infinite if both are 0.
    The root lies between half and all of the smaller of its values with one term alone.
    """
    without_substrate = np.full(overlap.size, np.inf)
    np.divide(overlap, compliance, out=without_substrate, where=compliance > 0)
    high = np.sqrt(without_substrate)
    if substrate:
        high = np.minimum(high, np.cbrt(overlap / substrate))
    high[overlap == 0] = 0.0
    rigid = np.isinf(high)
    high[rigid] = 0.0
    low = 0.5 * high
    for _ in range(60):
        middle = 0.5 * (low + high)
        above = substrate * middle**3 + compliance * middle**2 > overlap
        low, high = np.where(above, low, middle), np.where(above, middle, high)
    return np.where(rigid, np.inf, (0.5 * (low + high)) ** 3)


def slopes_of_forces(force, compliance, substrate):
    """Compute the slopes dF/d(delta_S) (n,) [N/m] of the contact law at forces (n,) [N].

    ``compliance`` and ``substrate`` are as for `forces_of_overlaps`. Slopes are 0 at forces of 0
    and at infinite ones.
    """
    root = np.cbrt(np.where(np.isinf(force), 0.0, force))
    slope = np.zeros(root.size)
    stiff = 3 * substrate * root + 2 * compliance
    np.divide(3 * root, stiff, out=slope, where=stiff > 0)
    return slope


def law_of(joint: PristineJoint, state: State) -> PairLaw:
    """Compute the contact law of a joint at a state.

    Soft peaks are those of the pristine walls, or of the state's walls if the choice is "current".
    """
    walls = state if joint.choices.peaks == "current" else joint
    ratio = joint.choices.peak_modulus_ratio if joint.effects.soft_peaks else 1.0
    asperity, rock_modulus = moduli(joint.rock, ratio, peaks(walls.upper), peaks(walls.lower))
    r = joint.choices.base_radius_in_cells * joint.spacing
    substrate = 3 / (4 * r * rock_modulus) if joint.effects.substrate else 0.0
    return PairLaw(asperity, rock_modulus, substrate, r)


def asperity_compliances(kappa, law: PairLaw):
    """Compute the compliances B (y, x) [m N^(-2/3)] of asperities from curvatures (y, x) [1/m]."""
    return np.cbrt(9 * kappa / (16 * law.asperity**2))


def overlaps_of(joint: PristineJoint, state: State, law: PairLaw):
    """Return the cells that may be in contact (n,), by flat index, and their overlaps (n,) [m].

    They are the cells that overlap without interaction, and those that carry force. The overlap
    delta_S is less the interaction of the state's forces, and may be negative.
    """
    overlap = state.upper + state.lower - ((joint.upper + joint.lower).max() - state.closure)
    cells = np.flatnonzero((overlap > 0) | (state.force > 0))
    overlap = overlap.ravel()[cells]
    if joint.effects.interaction:
        overlap = overlap - interaction(
            state.force, joint.spacing, law.base_radius, law.rock_modulus, cells
        )
    return cells, overlap


def pressures_over_limit(joint: PristineJoint, state: State):
    """Compute c(nu) p0 / sigma_c (y, x) [1], Eqs. (5), (22), (23), for the weaker wall.

    p0 is the largest Hertz pressure under the state's force. If the base bounds the strength, the
    ratio is at least the cube root of 3/2 c F / (sigma_c pi r^2), because p0 goes with the cube
    root of the force.
    """
    asperity, kappa = law_of(joint, state).asperity, _curvatures(joint, state)
    deformation = (9 * kappa * state.force**2 / (16 * asperity**2)) ** (1 / 3)
    pressure = 2 / np.pi * asperity * np.sqrt(deformation * kappa)
    over = max(
        (0.1251 * r.poisson_ratio**2 - 0.536 * r.poisson_ratio + 0.7695) / r.compressive_strength
        for r in walls_rocks(joint.rock)
    ) / np.where(state.crushed, joint.choices.crushed_strength_ratio, 1.0)
    if joint.choices.strength_bound == "none":
        return pressure * over
    base = np.pi * (joint.choices.base_radius_in_cells * joint.spacing) ** 2
    return np.maximum(pressure * over, np.cbrt(1.5 * state.force / base * over))


def _curvatures(joint: PristineJoint, state: State):
    """Compute the combined curvature of both walls (y, x) [1/m] at a state."""
    rule = joint.choices.largest_radius, joint.choices.concave
    return sum(curvature(z, joint.spacing, *rule) for z in (state.upper, state.lower))


def judge(joint: PristineJoint, state: State) -> Verdict:
    """Compute the errors of a state that should be at rest.

    The law of each contact is solved again, with the interaction of the reported forces.
    """
    force, law = state.force, law_of(joint, state)
    total = math.fsum(force.ravel())
    over_total = 1.0 / total if total > 0 else 0.0
    cells, overlap = overlaps_of(joint, state, law)
    compliance = asperity_compliances(_curvatures(joint, state), law).ravel()[cells]
    answer = forces_of_overlaps(np.maximum(overlap, 0.0), compliance, law.substrate)
    carried = force.ravel()[cells]
    # each contact's overlap is accurate to a few units in the last place
    slope = slopes_of_forces(answer, compliance, law.substrate)
    summed = state.upper + state.lower
    ulp = np.spacing(np.abs(summed).max() + abs(state.closure))
    walls = (joint.upper, state.upper), (joint.lower, state.lower)
    # the error of a reported force is in the residual, and may be a large part of a small force
    by_law = np.zeros_like(force)
    by_law.ravel()[cells] = np.where(np.isinf(answer), carried, answer)
    return Verdict(
        negative_force=abs(min(float(force.min()), 0.0)),
        residual=over_total * float(np.abs(answer - carried).sum()),
        rounding=over_total * float(slope.sum()) * float(ulp),
        without_overlap=over_total * float(carried[overlap <= 0].sum()),
        without_force=over_total * float(answer[carried == 0].sum()),
        load=abs(total - state.total_force) / total if total > 0 else abs(state.total_force),
        volume=max(volume_change(*pair) for pair in walls),
        raised=max(raised(*pair, joint.effects.gouge) for pair in walls),
        strength=_excess(joint, state._replace(force=by_law)),
    )


def volume_change(before, after):
    """Compute |sum z - sum z0| / sum |z0 - min z0| of a wall, summed without rounding.

    z0 are the heights (y, x) [m] ``before``, z those ``after``. The change of a flat wall is 0 or
    infinite.
    """
    change = abs(math.fsum([*after.ravel(), *(-before).ravel()]))
    if change == 0.0:
        return 0.0
    volume = math.fsum((before - before.min()).ravel())
    return change / volume if volume > 0.0 else math.inf


def raised(before, after, gouge):
    """Return the largest rise of a wall that nothing can cause, over its range of heights.

    Without gouge no cell can rise. With gouge no cell rises above the cell whose material it
    receives, so that only a rise of the highest height counts. The rise of a flat wall is 0 or
    infinite.
    """
    rise = float(after.max() - before.max() if gouge else (after - before).max())
    if rise <= 0.0:
        return 0.0
    reach = float(np.ptp(before))
    return rise / reach if reach > 0.0 else math.inf


def _excess(joint: PristineJoint, state: State) -> float:
    """Return the largest c p0/sigma_c - 1 of the contacts that can break, at least 0.

    It is 0 without breakage. With gouge locked contacts cannot break.
    """
    if not joint.effects.breakage:
        return 0.0
    load = pressures_over_limit(joint, state)
    if joint.effects.gouge:
        rms = math.sqrt(0.5 * (np.var(joint.upper) + np.var(joint.lower)))
        tie = joint.choices.tie_tolerance * rms
        load = np.where(locked(state.upper, state.lower, tie), 0.0, load)
    return max(float(load.max()) - 1.0, 0.0)

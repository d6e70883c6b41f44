"""Reference solver: Section 3 of the paper, step by step, for comparison.

Numbers in the comments are the paper's steps (first list) and its breakage steps (second).
"""

from functools import lru_cache

import numpy as np

from jointclosure.compilation.kernels import kernel
from jointclosure.mechanics.contact import asperity_compliance, force_of_overlap
from jointclosure.mechanics.gouge import drops, passed_share, shed, upper_share
from jointclosure.mechanics.strength import is_overstressed
from jointclosure.solvers.cells import curvature_among, is_peak, neighbourhood, overlapping_cells
from jointclosure.solvers.joint import Effort, Joint, Outcome, Settled

MOST_SWEEPS = 100_000  # passes over all contacts after which forces count as not settled; chosen


@kernel
def displacement_by_others(table, force, y, x):
    """Compute the displacement [m] of the cell (y, x) by all other contacts, Eqs. (17) and (18).

    ``force`` (ny, nx) [N] are the forces of the contacts; ``table`` (ny, nx) [m/N] is the influence
    by distance in cells, 0 at distance 0.
    """
    ny, nx = force.shape
    total = 0.0
    for v in range(ny):
        for w in range(nx):
            if force[v, w] > 0.0:
                total += table[abs(y - v), abs(x - w)] * force[v, w]
    return total


@kernel
def tallest_first(cells, upper, lower):
    """Return the indices (n,) that sort cells (n,) by the summed height of both walls.

    The tallest is the first. Cells are given by flat index.
    """
    nx = upper.shape[1]
    heights = np.empty(cells.size)
    for i in range(cells.size):
        y, x = divmod(cells[i], nx)
        heights[i] = -(upper[y, x] + lower[y, x])
    return np.argsort(heights, kind="mergesort")


@kernel
def lay_back(heights, y, x, neighbours):
    """Write the heights (8,) [m] of a cell's neighbours, as from `neighbourhood`, back to its wall.

    The wall ``heights`` (ny, nx) is changed in place. Neighbours outside the grid are left out.
    """
    ny, nx = heights.shape
    k = 0
    for dy in range(-1, 2):
        for dx in range(-1, 2):
            if dy != 0 or dx != 0:
                if 0 <= y + dy < ny and 0 <= x + dx < nx:
                    heights[y + dy, x + dx] = neighbours[k]
                k += 1


@lru_cache(maxsize=None)
def reference_kernel(interaction: bool, breakage: bool, gouge: bool, current_peaks: bool):
    """Return the kernel of steps 2 to 5 of the paper at one closure.

    What is off is not compiled: the parameters are constants of the kernel, so that Numba drops
    the branches of effects that do not act. ``current_peaks``: soft peaks are those of the
    present walls, not of the pristine ones.
    """

    @kernel
    def sweep_to_rest(
        upper,
        lower,
        offset,
        peaks,
        force,
        elastic_displacement,
        table,
        law,
        breakage_step,
        tie_tolerance,
        tolerance,
        most_sweeps,
    ):
        """Sweep over the contacts at one closure until their forces settle.

        Return the number of sweeps, the number of breakage steps, whether the forces settled within
        ``most_sweeps``, and a mask (y, x) of the locked pairs. Walls ``upper`` and ``lower`` (y, x)
        [m], the states ``peaks`` (y, x) of pairs, their ``force`` (y, x) [N] and
        ``elastic_displacement`` (y, x) [m] are changed in place. The ``offset`` [m] is the closure
        from first touch, ``table`` (ny, nx) [m/N] the influence by distance in cells, ``law`` a
        `ContactLaw`. A pair breaks in steps of ``breakage_step`` [m]. ``tolerance`` is the largest
        relative change of a force in the last sweep.
        """
        ny, nx = upper.shape
        around_upper = np.empty(8)
        around_lower = np.empty(8)
        falls_upper = np.empty(8)
        falls_lower = np.empty(8)
        locked = np.zeros((ny, nx), np.bool_)
        broken = 0
        for sweep in range(most_sweeps):
            # 2. the contacts, from the tallest overall asperity to the shortest
            cells = overlapping_cells(upper, lower, offset, peaks, law)[0]
            order = tallest_first(cells, upper, lower)
            change = 0.0
            again = False
            for i in order:
                # 3. deformation, interaction and force of each
                y, x = divmod(cells[i], nx)
                if interaction:
                    elastic_displacement[y, x] = displacement_by_others(table, force, y, x)
                neighbourhood(upper, y, x, around_upper)
                neighbourhood(lower, y, x, around_lower)
                steps = 0
                locked[y, x] = False
                while True:
                    overlap = upper[y, x] + lower[y, x] + offset - elastic_displacement[y, x]
                    state = peaks[y, x]
                    if current_peaks:
                        state = 2 * is_peak(upper[y, x], around_upper)
                        state += is_peak(lower[y, x], around_lower)
                        peaks[y, x] = state
                    kappa_upper = curvature_among(upper[y, x], around_upper, law)
                    kappa_lower = curvature_among(lower[y, x], around_lower, law)
                    kappa = kappa_upper + kappa_lower
                    # 4. breakage: 4.3 until the contact holds with its new geometry
                    if not breakage or not overlap > 0.0:
                        break
                    if not is_overstressed(
                        overlap,
                        kappa,
                        law.critical_indentation[state],
                        law.breaking_force[state],
                        law.substrate,
                        law.filling[state],
                    ):
                        break
                    # 4.1 the pair is lowered, the sharper asperity more
                    share = upper_share(kappa_upper, kappa_lower)
                    if gouge:
                        total_upper, least_upper = drops(
                            upper[y, x], around_upper, tie_tolerance, falls_upper
                        )
                        total_lower, least_lower = drops(
                            lower[y, x], around_lower, tie_tolerance, falls_lower
                        )
                        if total_upper == 0.0 and total_lower == 0.0:
                            locked[y, x] = True
                            break
                        share = passed_share(share, total_upper, total_lower)
                    loss_upper = breakage_step * share
                    loss_lower = breakage_step * (1.0 - share)
                    # 4.2 the gouge goes to the valleys around
                    if gouge and loss_upper > 0.0:
                        loss_upper = shed(
                            around_upper, loss_upper, falls_upper, total_upper, least_upper
                        )
                        lay_back(upper, y, x, around_upper)
                    if gouge and loss_lower > 0.0:
                        loss_lower = shed(
                            around_lower, loss_lower, falls_lower, total_lower, least_lower
                        )
                        lay_back(lower, y, x, around_lower)
                    upper[y, x] -= loss_upper
                    lower[y, x] -= loss_lower
                    steps += 1
                compliance = asperity_compliance(kappa, law.asperity_modulus[state])
                answer = force_of_overlap(overlap, law.substrate, compliance)[0]
                if answer != force[y, x]:
                    difference = abs(answer - force[y, x])
                    change = max(change, difference / answer if answer > 0.0 else np.inf)
                force[y, x] = answer
                if steps > 0:
                    broken += steps
                    again = True
                    break  # back to step 2
            # 5. the other contacts' interaction changed: back to step 2 until forces settle
            if not again and change <= tolerance:
                return sweep + 1, broken, True, locked
        return most_sweeps, broken, False, locked

    return sweep_to_rest


class ReferenceSolver:
    """Solver with the loop of the paper; see the module and `Solver`."""

    elastic_curve = None  # the paper takes steps even without breakage
    predict = None  # the paper's breakage is in fixed steps

    def settle(self, joint: Joint, closure: float, breakage_step: float) -> Settled:
        """Bring the joint to rest at a closure [m], in place, and return the state reached.

        Its walls, forces and interaction are changed. A pair of cells breaks in steps of
        ``breakage_step`` [m].
        """
        effects = joint.effects
        sweep_to_rest = reference_kernel(
            joint.interaction_acts,
            effects.breakage,
            effects.gouge,
            joint.choices.peaks == "current",
        )
        offset = closure - joint.first_touch
        # cells that lost contact since the last step carry no force
        summed = joint.upper + joint.lower + offset
        joint.force[summed <= 0.0] = 0.0
        sweeps, broken, converged, locked = sweep_to_rest(
            joint.upper,
            joint.lower,
            float(offset),
            joint.peaks,
            joint.force,
            joint.interaction,
            joint.influence_table if joint.interaction_acts else np.zeros((1, 1)),
            joint.law,
            float(breakage_step),
            joint.tie_tolerance,
            float(joint.numerics.sweep_tolerance),
            MOST_SWEEPS,
        )
        outcome = Outcome.CONVERGED if converged else Outcome.NOT_CONVERGED
        if not np.all(np.isfinite(joint.force)):
            outcome = Outcome.RIGID_CONTACT
        effort = Effort(settled=1, rounds=sweeps, products=sweeps, breakage_steps=broken)
        return joint.describe(closure, outcome, locked, effort)

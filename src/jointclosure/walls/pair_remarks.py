"""Remarks on a registered pair of walls: sentences on its overlap, contact, mating and doubts."""

import math

import numpy as np

from jointclosure.inputs.remarks import Caution, caution
from jointclosure.statistics.number_texts import grid_text, percent
from jointclosure.statistics.standard_errors import CONFIDENCE
from jointclosure.walls import plausibility
from jointclosure.walls.mating import Mismatch
from jointclosure.walls.motion import Motion
from jointclosure.walls.overlap import Overlap
from jointclosure.walls.registered_pair import RegisteredPair
from jointclosure.walls.rotation_search import LEAST_OVERLAP

STEEP_PLANE = 5.0  # inclination [degrees] of the walls' common plane above which users are warned
STEEP_WEDGE = 1.0  # inclination [degrees] of the walls to each other above which users are warned
_FAR = 1.5
"""Closure until one cell in a thousand touches, in standard deviations of the aperture, above which
users are warned that the first contact may be a spike."""
_WORSE, _LOWER = 2.0, 0.02
"""Limits of `best_fit_remarks`; chosen."""
_ALIKE = 0.99  # correlation above which walls that mate at all wavelengths may be one wall


def wall_remarks(pair: RegisteredPair, overlap: Overlap, in_frame: bool) -> list[str]:
    """Return the remarks on the walls of a registered pair and on their ``overlap``.

    ``in_frame`` is whether the walls lie as they were scanned, in a frame that both scans share; a
    remark on their distance is then added. The remarks and the scale that the pair already has are
    not read.
    """
    cells = f"{grid_text(pair.upper.shape, pair.spacing)} (x, y)"
    shares = [f"{100.0 * share:.0f} %" for share in overlap.shares]
    both = bool(pair.fits)
    if both:
        remarks = [
            f"overlap: {cells}, {shares[0]} of the upper scan and {shares[1]} of the lower",
            f"the plane common to both walls, inclined by {overlap.inclination:.2f} degrees, was "
            f"removed; the walls were left inclined to each other by {overlap.relative:.3f} "
            "degrees and are set parallel",
            f"heights correlate by {pair.correlation:.3f}; {describe_mating(pair.mismatch)}",
        ]
    else:  # one wall is flat and has no waves
        remarks = [
            f"largest rectangle of the scan without missing heights: {cells}, {shares[0]} of it; "
            "its mean plane was removed"
        ]
    remarks += _first_touch_remarks(pair.aperture, *pair.first_touch_cell)
    remarks += map(caution, _overlap_doubts(overlap, both, bool(pair.motion.covariance.any())))
    if pair.mismatch.wavelength == 0.0 and pair.correlation > _ALIKE:
        alike = (
            "the walls fit each other at all wavelengths of the grid, as two scans of one wall "
            "do; check that the files are of different walls"
        )
        remarks.append(caution(alike))
    return [*remarks, _frame_remark(overlap)] if in_frame else remarks


def best_fit_remarks(pair: RegisteredPair, best: Overlap) -> list[str]:
    """Warn of walls in their scanned position that fit clearly better in that of best fit.

    ``best`` is their overlap there. They do if what their heights do not share (1 less the
    correlation) is more than `_WORSE` times as much, and the correlation is lower by `_LOWER`.
    """
    upper, lower = best.parallel_walls
    of_best = float(np.corrcoef(upper.ravel(), -lower.ravel())[0, 1])
    here = pair.correlation
    if pair.mated is None or of_best - here < _LOWER or 1.0 - here < _WORSE * (1.0 - of_best):
        return []
    _, x, y = 1e3 * pair.motion.difference_to(pair.mated)
    return [
        caution(
            f"heights of the walls correlate by {here:.2g} in their scanned position, and by "
            f"{of_best:.2g} at the best fit, which lies ({x:.3g}, {y:.3g}) mm from it along "
            "(x, y): closures are those of walls that are shifted by this distance; leave "
            "--shift scanned out if the scans were meant to mate"
        )
    ]


def levelling_remark(levelling: Motion) -> str:
    """Say that walls in a scanned position close along the normal of the joint, and not along z.

    ``levelling`` turned the scans until they were level.
    """
    shift = math.sin(math.radians(levelling.tilt))
    return (
        f"the joint is inclined by {levelling.tilt:.2g} degrees in the scans: they were turned "
        "until it is level, and the walls close along its normal. Each mm that the scans lie "
        f"apart along their z axis becomes {shift:.2g} mm of shift along the joint"
    )


def width_remarks(pair: RegisteredPair) -> list[str]:
    """Return a remark that the standard errors of the position were enlarged; none if not.

    They are too small on walls that are only a few mismatch wavelengths wide.
    """
    factor = pair.error_factor
    if factor == 1.0 or not pair.motion.covariance.any():
        return []
    angle, *errors = (factor * error for error in pair.motion.standard_errors())
    x, y = (f"{1e3 * error:.4f}" for error in errors)
    return [
        f"the overlap is only {pair.mismatch_wavelengths:.2g} mismatch wavelengths wide: in a "
        f"test, errors of rotation and shift on such walls were {factor:.2g} times as large as "
        f"these standard errors. They are therefore taken as {angle:.3f} degrees and "
        f"({x}, {y}) mm in the range of the joint (docs/two_scans.md#how-the-scans-are-registered)"
    ]


def _first_touch_remarks(aperture: np.ndarray, y: int, x: int) -> list[str]:
    """Return remarks on the aperture (y, x) [m] at first touch, in the cell (y, x).

    The second is a caution if the first contact stands out so far that it may be a spike.
    """
    early = float(np.quantile(aperture, 1e-3))
    touches = f"one cell in a thousand touches after {1e3 * early:.3g} mm of closure"
    exact = (
        "this length and the closure until one cell in a thousand touches are those of the walls "
        "as registered; joints of the range are at other positions, where both lengths differ"
    )
    spike = (
        "the first contact stands out far and may be a remaining spike; use closures since "
        "seating, not those from first touch"
    )
    return [
        f"at first touch, at cell (x, y) = ({x}, {y}), the mean aperture is "
        f"{1e3 * aperture.mean():.3g} mm; {exact}",
        caution(spike, f"{touches}: ") if early > _FAR * aperture.std() else touches,
    ]


def _frame_remark(overlap: Overlap) -> str:
    """Return a remark on the mean distance of walls as scanned, or a caution that it is not known.

    If heights of both scans have the same zero, the upper wall lies above the lower one nearly
    everywhere, or below it nearly everywhere if the files are interchanged. If each wall lies
    partly below the other, the zeros differ.
    """
    gaps = overlap.gap
    gap = float(np.mean(gaps))
    where = f"{1e3 * abs(gap):.3g} mm {'above' if gap > 0.0 else 'below'} the lower one"
    lies = f"in the scans the upper wall lies {where} in the mean"
    below = float(np.mean(gaps < 0.0))
    if below > plausibility.INTERCHANGED:
        return caution("the walls are interchanged or heights count downwards", f"{lies}: ")
    if below < 1.0 - plausibility.INTERCHANGED:
        return lies
    return caution(
        "the scans have no common zero of heights, as each wall lies partly below the other: the "
        "data do not show whether the files are interchanged, in which case the aperture would be "
        "that of other walls; check that the first file is the upper wall"
    )


def _overlap_doubts(overlap: Overlap, both: bool, best_fit: bool) -> list[str]:
    """Return sentences on holes, on a small overlap, and on large inclinations of the walls.

    ``both`` is whether neither wall is flat, ``best_fit`` whether they are in the position of best
    fit. The list is empty if nothing is unusual.
    """
    doubts = []
    share = 100.0 * max(overlap.shares)
    size = overlap.upper.size
    lost = int(overlap.holes.sum())
    if lost > 0:
        upper, lower = (int(part.sum()) for part in (overlap.upper_holes, overlap.lower_holes))
        doubts.append(
            f"{lost} of {size} cells ({percent(lost / size)}) lie in holes of a scan "
            f"({upper} of the upper, {lower} of the lower); they were taken out of contact, with "
            "the largest aperture of those around them"
        )
    if overlap.cut > 0:
        doubts.append(
            f"{overlap.cut} cells in large holes of a scan were left out: the joint is the largest "
            f"rectangle without such holes, {share:.0f} % of the smaller scan"
        )
    if both and max(overlap.shares) < LEAST_OVERLAP:
        question = (
            ", even in the position of best fit: are the scans of the same part of the joint?"
            if best_fit
            else ": are the scans in one frame? (--shift mated moves them to the best fit)"
        )
        doubts.append(
            f"the walls overlap in {share:.0f} % of the smaller scan, less than "
            f"{100.0 * LEAST_OVERLAP:.0f} %{question}"
        )
    if overlap.inclination > STEEP_PLANE:
        doubts.append(
            f"the {'common plane' if both else 'plane'} is inclined by "
            f"{overlap.inclination:.1f} degrees, more than {STEEP_PLANE:g}; it was removed along "
            "z, so that heights are not normal to it; turn the scans"
        )
    if both and overlap.relative > STEEP_WEDGE:
        doubts.append(
            f"the walls are inclined to each other by {overlap.relative:.1f} degrees, more than "
            f"{STEEP_WEDGE:g}; walls of one joint are about parallel"
        )
    return doubts


def describe_mating(mismatch: Mismatch) -> str:
    """Return words on the wavelengths at which two walls are mated."""
    if mismatch.wavelength == 0.0:
        return "the walls are mated at all wavelengths of the grid"
    if np.isinf(mismatch.wavelength):
        return "the walls are mated at no wavelength"
    low = f"{1e3 * mismatch.low:.3g}" if mismatch.low > 0.0 else "the grid's shortest"
    high = f"{1e3 * mismatch.high:.3g} mm" if np.isfinite(mismatch.high) else "the walls' length"
    return (
        f"the walls are mated at wavelengths beyond {1e3 * mismatch.wavelength:.3g} mm (mismatch "
        f"wavelength, where they correlate by 0.5; {100 * CONFIDENCE:g} % interval {low} to {high})"
    )


def coarser_grid_caution(spacing: float, step: int) -> Caution:
    """Return a caution that heights were taken on a coarser grid than that of a spacing [m].

    The grid has ``step`` times the spacing, which is the usual one.
    """
    return caution(
        f"heights were taken every {1e3 * step * spacing:.4g} mm, which the scans resolve, and not "
        f"every {1e3 * spacing:.4g} mm. The range has joints of both spacings, with lost "
        f"waves drawn at random (--spacing {1e3 * spacing:.4g} simulates the joint at that spacing)"
    )


def scale_caution(scale: float, error: float) -> Caution:
    """Return a caution that the scales of both walls' heights differ.

    ``scale`` is the scale of the upper wall over that of the lower wall, ``error`` its relative
    standard error.
    """
    return caution(
        f"heights of the upper wall are {scale:.3f} +- {scale * error:.3f} (standard error) times "
        "those of the lower one at the waves by which they mate: calibrate both scans. The range "
        "has walls of one scale, between both"
    )

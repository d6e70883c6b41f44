"""Summary of a registered pair of walls in a few lines; `RegisteredPair.remarks` say more."""

from jointclosure.inputs.remarks import cautions
from jointclosure.statistics.number_texts import grid_text
from jointclosure.walls.pair_remarks import describe_mating, levelling_remark
from jointclosure.walls.registered_pair import RegisteredPair

_ORDER = (
    "the first file is taken as the upper wall: the positions of walls that are moved to their "
    "best fit do not show whether the files are interchanged"
)
"""Caution on the order of the files of scans with frames of their own."""


def summary_of(pair: RegisteredPair, has_range: bool = True) -> list[str]:
    """Return lines on the orientation, position and mating of a pair of walls, and its warnings.

    ``has_range`` is whether the results of the joint will have a range, which has errors of the
    position.
    """
    lines = [_orientation(pair), *_position(pair, has_range), _mating(pair)]
    return [line for line in lines if line] + cautions(pair.remarks)


def _orientation(pair: RegisteredPair) -> str:
    """Return a line on the orientation of the upper wall, and how well this and the next one fit.

    It is empty if one wall is flat.
    """
    if not pair.fits:
        return ""
    of_fits = f"slopes correlate by {pair.fits[0]}"
    if len(pair.fits) > 1:
        of_fits += f", next {pair.fits[1]}"
    return f"orientation of the upper wall: {pair.orientation}; {of_fits}"


def _position(pair: RegisteredPair, has_range: bool) -> list[str]:
    """Return lines on where the upper wall was moved, with its standard errors in the range.

    There is none if one wall is flat.
    """
    if not pair.fits:
        return []
    if not pair.motion.covariance.any():
        of_range = ", which has no error in the range" if has_range else ""
        levelled = [levelling_remark(pair.levelling)] if pair.levelling else []
        return [f"the walls were left in their scanned position{of_range}", *levelled]
    motion = pair.mated or pair.motion
    angle, *errors = (pair.error_factor * error for error in motion.standard_errors())
    shift = 1e3 * (motion.place - motion.middle)[:2]
    x, y = (f"{d:.4f} +- {1e3 * error:.4f}" for d, error in zip(shift, errors, strict=True))
    errors_of = "the standard errors of the range" if has_range else "standard errors"
    return [
        f"the upper wall was turned by {motion.angle:.3f} +- {angle:.3f} degrees, and its middle "
        f"moved by ({x}, {y}) mm along (x, y), with {errors_of}; {_ORDER}"
    ]


def _mating(pair: RegisteredPair) -> str:
    """Return a line on the size of the overlap, and from which wavelength on the walls mate."""
    line = f"overlap: {grid_text(pair.upper.shape, pair.spacing)}"
    if not pair.fits:
        return f"{line}; one wall is flat"
    return f"{line}; heights correlate by {pair.correlation:.3f}; {describe_mating(pair.mismatch)}"

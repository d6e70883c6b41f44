"""Summary of a registered pair of walls in a few lines; `RegisteredPair.remarks` say more."""

from jointclosure.inputs.remarks import cautions
from jointclosure.statistics.number_texts import grid_text
from jointclosure.walls.pair_remarks import describe_mating
from jointclosure.walls.registered_pair import RegisteredPair


def summary_of(pair: RegisteredPair) -> list[str]:
    """Return lines on the orientation, position and mating of a pair of walls, and its warnings."""
    lines = [_orientation(pair), _position(pair), _mating(pair)]
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


def _position(pair: RegisteredPair) -> str:
    """Return a line on where the upper wall was moved, with its standard errors in the range.

    It is empty if one wall is flat.
    """
    if not pair.fits:
        return ""
    if not pair.motion.covariance.any():
        return "the walls were left in their scanned position, which has no error in the range"
    motion = pair.mated or pair.motion
    angle, *errors = (pair.error_factor * error for error in motion.standard_errors())
    shift = 1e3 * (motion.place - motion.middle)[:2]
    x, y = (f"{d:.4f} +- {1e3 * error:.4f}" for d, error in zip(shift, errors, strict=True))
    return (
        f"the upper wall was turned by {motion.angle:.3f} +- {angle:.3f} degrees, and its middle "
        f"moved by ({x}, {y}) mm along (x, y), with the standard errors of the range"
    )


def _mating(pair: RegisteredPair) -> str:
    """Return a line on the size of the overlap, and from which wavelength on the walls mate."""
    line = f"overlap: {grid_text(pair.upper.shape, pair.spacing)}"
    if not pair.fits:
        return f"{line}; one wall is flat"
    return f"{line}; heights correlate by {pair.correlation:.3f}; {describe_mating(pair.mismatch)}"

"""Pairs of walls on which ranges of results were tested, and walls that are unlike them."""

from typing import NamedTuple

from jointclosure.walls.registered_pair import RegisteredPair
from jointclosure.walls.wall_roughness import joint_jrc


class Domain(NamedTuple):
    """Largest rotation and tilt [degrees] of the upper wall, noise [m] of each scan, and JRC.

    Rotations count from the nearest quarter turn, which lays the nodes of a grid on nodes. The JRC
    is the mean of both walls, by their RMS slopes (`joint_jrc`).
    """

    rotation: float
    tilt: float
    noise: float
    jrc: float


TESTED = Domain(rotation=45.0, tilt=8.0, noise=15e-6, jrc=30.0)
"""Pairs of known truth of benchmarks/range_coverage.py, by which ranges of results are tested."""


def beyond_tested(pair: RegisteredPair) -> list[str]:
    """Return a sentence on how registered walls are outside of the `TESTED` domain; none if inside.

    Noise is outside if the low end of its 95 % interval is above the largest tested noise.
    """
    rotation = abs((pair.motion.angle + 45.0) % 90.0 - 45.0)
    reasons = []
    if rotation > TESTED.rotation:
        reasons.append(
            f"the upper wall was turned by {rotation:.3g} degrees from a quarter turn of the grid "
            f"(tested: up to {TESTED.rotation:g})"
        )
    if pair.motion.tilt > TESTED.tilt:
        reasons.append(
            f"the upper wall was tilted by {pair.motion.tilt:.3g} degrees (tested: up to "
            f"{TESTED.tilt:g})"
        )
    reasons += [
        f"the noise of the {side} wall is at least {1e6 * low:.2g} um (tested: up to "
        f"{1e6 * TESTED.noise:g})"
        for side, low, _ in pair.scan_noise
        if low > TESTED.noise
    ]
    jrc = joint_jrc((pair.upper, pair.lower), pair.spacing)
    if jrc > TESTED.jrc:
        reasons.append(f"their JRC is {jrc:.3g} (tested: up to {TESTED.jrc:g})")
    if not reasons:
        return []
    return [
        f"ranges of the results were not tested on such walls: {'; '.join(reasons)}; "
        "they may contain the truth less often than stated (docs/coverage.md)"
    ]

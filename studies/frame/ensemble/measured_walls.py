"""Scanned walls of a rock, interpolated on the joint's grid and cut into joints."""

import json
from collections.abc import Iterator

import numpy as np
import xarray as xr

from jointclosure.engine.settings import SurfaceSettings, Walls
from jointclosure.engine.walls import seeds_of
from jointclosure.inputs import InputError, naming
from jointclosure.inputs.remarks import cautions
from jointclosure.parameters import AS_IT_IS
from jointclosure.statistics.randomness import seed_of
from jointclosure.walls.measured import Cloud, Scan, filled, wall_on_grid
from jointclosure.walls.measures import hurst_of
from jointclosure.walls.outliers import without_plateaus
from jointclosure.walls.plausibility import doubts, slope_doubts, smoothing_of, unit_doubts
from jointclosure.walls.registration import registered
from jointclosure.walls.roughness import jrc_of_z2, rms_slope
from studies.frame.ensemble.windows import Cutter, MeasuredWalls, disjoint


def prepared_walls(
    scans: dict[str, Scan | Cloud],
    settings: Walls,
    spacing: float,
    jrc_relation: str,
    unusual_values: bool = False,
) -> xr.Dataset:
    """Put scanned walls on the grid of the joint, in full size.

    Parameters
    ----------
    scans : dict
        Scans by wall: "upper", "lower" or both.
    settings : Walls
    spacing : float
        Grid spacing of the joint [m].
    jrc_relation : str
        Key of `jointclosure.walls.roughness.RELATIONS`, for the reported JRC.
    unusual_values : bool
        Whether to accept walls that are probably wrong, as for
        `jointclosure.walls.registration.registered`. It also applies to walls that are not
        registered.

    Returns
    -------
    Dataset
        ``upper``, ``lower`` or both over (y, x) [m], heights towards the other wall, with slope,
        Hurst exponent, JRC and share of missing cells of each wall.

    Raises
    ------
    InputError
        If walls cannot be put on the grid, or are probably wrong.
    """
    walls = xr.Dataset(attrs={"spacing_m": spacing, "partner": ""})
    if settings.bring_together:
        if len(scans) < 2:
            raise InputError(
                f"{settings.upper} and {settings.lower}: bring_together must be false in a study "
                "where one wall is flat"
            )
        with naming(f"{settings.upper} and {settings.lower}"):
            pair = registered(
                scans["upper"],
                scans["lower"],
                spacing,
                orientation=settings.orientation,
                shift=settings.shift,
                cut_spikes=settings.spikes == "cut",
                largest_filled_share=settings.largest_filled_share,
                unusual_values=unusual_values,
            )
        heights = {"upper": (pair.upper, 0.0), "lower": (pair.lower, 0.0)}
        walls.attrs["registration"] = "; ".join(pair.report)
    else:
        if not unusual_values:
            scans = {side: without_plateaus(scan) for side, scan in scans.items()}
        heights = _as_they_lie(scans, settings, spacing)
    if not (unusual_values or settings.bring_together):
        _check_plausible({side: wall for side, (wall, _) in heights.items()}, settings, spacing)
    for side, (wall, share) in heights.items():
        # relations and synthesis are valid up to H = 1; beyond, walls are smooth at the spacing
        z2, hurst = _slope(wall, spacing), float(np.clip(hurst_of(wall), 0.05, 1.0))
        about = {
            "units": "m",
            "long_name": f"measured height of the {side} wall towards the other",
            "missing_share": share,
            "z2": z2,
            "hurst": hurst,
            "jrc": jrc_of_z2(z2, spacing, hurst, jrc_relation),
            "jrc_relation": jrc_relation,
        }
        remarks = scans[side].remarks
        if not settings.bring_together:  # else in the registration's report
            remarks += smoothing_of(scans[side], wall, spacing, _common_bounds(scans))
        if remarks:  # what reading left out is stored with the results
            about["remarks"] = "; ".join(remarks)
        walls[side] = (("y", "x"), wall, about)
    missing = {"upper", "lower"} - set(scans)
    if missing:
        walls.attrs["partner"] = getattr(settings, missing.pop())
    return walls


def _check_plausible(walls: dict[str, np.ndarray], settings: Walls, spacing: float) -> None:
    """Raise `InputError` if units or orientation of the walls are probably wrong."""
    both = len(walls) == 2
    problems = doubts(**walls, spacing=spacing) if both else slope_doubts(walls, spacing)
    if problems := problems or unit_doubts(walls, spacing)[0]:
        raise InputError(
            f"{settings.upper} and {settings.lower}: {'; '.join(problems)}; {AS_IT_IS}"
        )


def _as_they_lie(
    scans: dict[str, Scan | Cloud], settings: Walls, spacing: float
) -> dict[str, tuple[np.ndarray, float]]:
    """Return unregistered walls, heights towards the other wall, with shares of missing cells."""
    bounds = _common_bounds(scans)
    heights: dict[str, tuple[np.ndarray, float]] = {}
    for side, scan in scans.items():
        try:
            wall = wall_on_grid(scan, spacing, bounds)
            share = float(np.mean(~np.isfinite(wall)))
            wall = filled(wall, settings.missing, settings.largest_filled_share)
        except InputError as error:
            reasons = [str(error), *cautions(scan.remarks)]
            raise InputError(f"{getattr(settings, side)}: {'; '.join(reasons)}") from None
        others = [other.shape for other, _ in heights.values()]
        if any(shape != wall.shape for shape in others):
            sizes = [*others, wall.shape]
            raise InputError(
                f"{settings.upper} and {settings.lower}: {sizes[0]} and {sizes[1]} cells "
                "(y, x) at the spacing of the grid; both scans must cover the same cells (use "
                "bring_together: true to find the area that both cover)"
            )
        sign = -1.0 if side in settings.inverted else 1.0
        heights[side] = (sign * wall, share)
    return heights


def cutter_of(walls: xr.Dataset, shape: tuple[int, int], order_seed: int, normalise: str) -> Cutter:
    """Return the cutter of joints for the walls of `prepared_walls`."""
    first = next(iter(walls.data_vars.values()))
    measured = MeasuredWalls(
        {str(name): wall.values for name, wall in walls.data_vars.items()},
        walls.attrs["partner"],
        float(walls.attrs["spacing_m"]),
        float(first.attrs["z2"]),
        float(first.attrs["hurst"]),
    )
    return Cutter(measured, shape, order_seed, normalise)


def cut_walls(walls: xr.Dataset, settings: SurfaceSettings) -> Iterator[tuple]:
    """Generate the pairs (upper, lower) of a block, cut out of the walls of `prepared_walls`."""
    order = seed_of(settings.root_seed, *settings.seeds_named_by, "windows")
    cutter = cutter_of(walls, settings.grid.shape, order, settings.surface.normalise)
    for realization, seed in enumerate(seeds_of(settings), start=settings.first_realization):
        joint = cutter.joint(realization, seed)
        yield joint.upper, joint.lower


def room(cutter: Cutter) -> dict[str, int]:
    """Count the joints that can be cut from the walls, and those that share no cell."""
    return {
        "windows": len(cutter.windows),
        "windows_side_by_side": disjoint(cutter.windows, cutter.shape),
    }


def described(walls: dict[str, xr.Dataset]) -> str:
    """Return JSON of the files, digests and roughness of the scanned walls of each rock."""
    return json.dumps(
        {
            rock: dict(dataset.attrs)
            | {str(k): dict(v.attrs) for k, v in dataset.data_vars.items()}
            for rock, dataset in walls.items()
        },
        default=float,
        sort_keys=True,
    )


def _slope(wall: np.ndarray, spacing: float) -> float:
    """Return the RMS slope of a wall, which may have missing cells."""
    if np.isfinite(wall).all():
        return rms_slope(wall, spacing)
    steps = np.concatenate([np.diff(wall, axis=axis).ravel() for axis in (0, 1)])
    return float(np.sqrt(np.nanmean(steps**2))) / spacing


def _common_bounds(scans: dict[str, Scan | Cloud]) -> np.ndarray | None:
    """Return the smallest and largest (x, y) that two point clouds share; None for other scans."""
    clouds = [scan.points[:, :2] for scan in scans.values() if isinstance(scan, Cloud)]
    if len(clouds) < 2:
        return None
    low = np.max([points.min(axis=0) for points in clouds], axis=0)
    high = np.min([points.max(axis=0) for points in clouds], axis=0)
    if not (high > low).all():
        raise InputError("upper and lower: the scans' points do not overlap in x and y")
    return np.array([low, high])

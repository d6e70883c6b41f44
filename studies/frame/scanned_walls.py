"""Scanned walls of a study's rock: put on the grid of the joints, and cut into the joints."""

import json
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import xarray as xr

from jointclosure.inputs import InputError, naming
from jointclosure.inputs.remarks import cautions
from jointclosure.parameters import AS_IT_IS
from jointclosure.statistics.randomness import generator, seed_of
from jointclosure.walls.gridding import FLAT, Cloud, Scan, wall_on_grid
from jointclosure.walls.interpolation_remarks import interpolation_remarks
from jointclosure.walls.jrc import jrc_of_z2, rms_slope
from jointclosure.walls.levelling import levelled_together
from jointclosure.walls.missing_heights import fill_missing
from jointclosure.walls.planes import detrended
from jointclosure.walls.plausibility import doubts, unit_doubts
from jointclosure.walls.registration import registered
from jointclosure.walls.scan_defects import inspected_together
from jointclosure.walls.scan_quality import quality_of, quality_remarks
from jointclosure.walls.scans import read_scan
from jointclosure.walls.synthesis import Spectrum, synthetic_wall
from jointclosure.walls.wall_roughness import hurst_of
from studies.frame.keys import Grid
from studies.frame.rocks import ScannedWalls, wall_files
from studies.frame.settings import SIDES, ClosureSettings, SurfaceSettings, seeds_of

REGISTRATION = ("orientation", "shift", "spikes", "largest_filled_share")
"""Keys of scanned walls that are arguments of `registered`."""


def walls_of_files(
    settings: ScannedWalls, spacing: float, jrc_relation: str, unusual_values: bool
) -> xr.Dataset:
    """Read the scans that ``settings`` name, and return the dataset of `prepared_walls`.

    The grid has a ``spacing`` [m]. ``jrc_relation`` is the name of a relation in
    `jointclosure.walls.jrc.RELATIONS`, which gives the equivalent JRC of each wall. Errors are as
    for `read_scan` and `prepared_walls`.
    """
    stated: dict[str, Any] = {"units": settings.units, "variable": settings.variable}
    scans = {
        side: read_scan(file, scan_spacing=settings.spacing, **stated)
        for side, file in wall_files(settings).items()
    }
    return prepared_walls(scans, settings, spacing, jrc_relation, unusual_values)


def prepared_walls(
    scans: dict[str, Scan | Cloud],
    settings: ScannedWalls,
    spacing: float,
    jrc_relation: str,
    unusual_values: bool = False,
) -> xr.Dataset:
    """Return a dataset of the walls (y, x) [m] of scans on a grid of a ``spacing`` [m].

    ``scans`` has "upper", "lower" or both. By ``settings`` the walls are registered (`registered`),
    or are levelled and stay as they lie. Heights count towards the other wall. Attributes of each
    wall are its RMS slope, Hurst exponent, equivalent JRC, share of missing cells and remarks.
    Attributes of the dataset are the partner of a single wall ("" for two walls), warnings, and the
    report of the registration.

    Raises
    ------
    InputError
        If a scan cannot be put on the grid, if the scans do not cover the same cells, or if heights
        are implausible and not ``unusual_values``.
    """
    walls = xr.Dataset(attrs={"spacing_m": spacing, "partner": ""})
    warnings: list[str] = []
    files = f"{settings.upper} and {settings.lower}"
    bounds = None
    measured = scans
    if settings.bring_together:
        if len(scans) < 2:
            raise InputError(
                f"{files}: bring_together must be false in a study where one wall is flat"
            )
        stated: dict[str, Any] = {name: getattr(settings, name) for name in REGISTRATION} | scans
        with naming(files):
            pair = registered(spacing=spacing, unusual_values=unusual_values, **stated)
        heights = {"upper": (pair.upper, 0.0), "lower": (pair.lower, 0.0)}
        walls.attrs["registration"] = "; ".join(pair.remarks)
        warnings += cautions(pair.remarks)
    else:
        if not unusual_values:
            with naming(files):
                scans = inspected_together(scans)
        measured = scans
        with naming(files):
            scans = levelled_together(scans)
        bounds = _common_bounds(scans)
        heights = _as_they_lie(scans, bounds, settings, spacing)
        lying = {side: wall for side, (wall, _) in heights.items()}
        if not unusual_values:
            both = len(lying) == 2
            units = unit_doubts(lying, spacing)
            problems = doubts(**lying, spacing=spacing) if both else units.impossible
            if problems := problems or units.contradictions:
                raise InputError(f"{files}: {'; '.join(problems)}; {AS_IT_IS}")
    for side, (wall, share) in heights.items():
        # relations and synthesis hold up to H = 1; walls with a larger H are smooth at the spacing
        z2 = _slope(wall, spacing)
        hurst = float(np.clip(hurst_of(wall), 0.05, 1.0))
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
            low = None if bounds is None else bounds[0]
            remarks += interpolation_remarks(scans[side], wall, spacing, low)
            quality = quality_of(measured[side], scans[side])
            remarks += tuple(quality_remarks(quality, wall, spacing))
            warnings += [f"{side} wall: {remark}" for remark in cautions(remarks)]
        if remarks:  # what reading left out is stored with the results
            about["remarks"] = "; ".join(remarks)
        walls[side] = (("y", "x"), wall, about)
    for missing in {*SIDES} - set(scans):
        walls.attrs["partner"] = getattr(settings, missing)
    walls.attrs["warnings"] = "\n".join(warnings)
    return walls


def _as_they_lie(
    scans: dict[str, Scan | Cloud],
    bounds: np.ndarray | None,
    settings: ScannedWalls,
    spacing: float,
) -> dict[str, tuple[np.ndarray, float]]:
    """Return the heights (y, x) [m] and the share of missing cells of walls, by side, as scanned.

    Heights count towards the other wall. Missing cells are filled or kept as ``settings`` say, and
    the share is that before. ``bounds`` are those of `_common_bounds`. Raise `InputError` if a scan
    cannot be put on the grid, or if both walls have different numbers of cells.
    """
    heights: dict[str, tuple[np.ndarray, float]] = {}
    for side, scan in scans.items():
        try:
            wall = wall_on_grid(scan, spacing, bounds)
            share = float(np.mean(~np.isfinite(wall)))
            wall = fill_missing(wall, settings.missing, settings.largest_filled_share)
        except InputError as error:
            reasons = [str(error), *cautions(scan.remarks)]
            raise InputError(f"{getattr(settings, side)}: {'; '.join(reasons)}") from None
        heights[side] = ((-1.0 if side in settings.inverted else 1.0) * wall, share)
    sizes = [wall.shape for wall, _ in heights.values()]
    if len(set(sizes)) > 1:
        raise InputError(
            f"{settings.upper} and {settings.lower}: {sizes[0]} and {sizes[1]} cells "
            "(y, x) at the spacing of the grid; both scans must cover the same cells (use "
            "bring_together: true to find the area that both cover)"
        )
    return heights


def _slope(wall: np.ndarray, spacing: float) -> float:
    """Return the RMS slope of a wall (y, x) [m] at a spacing [m]; NaN (missing) is ignored."""
    if np.isfinite(wall).all():
        return rms_slope(wall, spacing)
    steps = np.concatenate([np.diff(wall, axis=axis).ravel() for axis in (0, 1)])
    return float(np.sqrt(np.nanmean(steps**2))) / spacing


def _common_bounds(scans: dict[str, Scan | Cloud]) -> np.ndarray | None:
    """Return the lowest and highest place (2, 2) (x, y) [m] that two clouds of points both cover.

    None unless both scans are clouds. Raise `InputError` if they do not overlap.
    """
    clouds = [scan.points[:, :2] for scan in scans.values() if isinstance(scan, Cloud)]
    if len(clouds) < 2:
        return None
    low = np.max([points.min(axis=0) for points in clouds], axis=0)
    high = np.min([points.max(axis=0) for points in clouds], axis=0)
    if not (high > low).all():
        raise InputError("upper and lower: the scans' points do not overlap in x and y")
    return np.array([low, high])


def prepare_walls(
    walls: ScannedWalls,
    digests: dict[str, str],
    grid: Grid,
    jrc_relation: str,
    unusual_values: bool,
    realizations: int,
    log: Callable[[str], None],
    show: Callable[[str], None],
) -> xr.Dataset:
    """Read the scanned walls of a rock, and return them on the grid with all that is known of them.

    The dataset is that of `prepared_walls`, with the files, their ``digests`` (`wall_digests`) and
    the room for joints as further attributes. ``show`` is called with the warnings of the scans,
    ``log`` with all details. Raise `InputError` if there is no room for ``realizations`` joints, or
    as `walls_of_files`.
    """
    prepared = walls_of_files(walls, grid.spacing, jrc_relation, unusual_values)
    log(prepared.attrs.get("registration", "as they lie"))
    for warning in prepared.attrs["warnings"].splitlines():
        show(f"{walls.lower}, {walls.upper}: {warning}")
    for side, file in wall_files(walls).items():
        prepared[side].attrs |= {"file": file, "sha256": digests[side]}
        log(f"{side}: {prepared[side].attrs}")
    cutter = Cutter(prepared, grid.shape, 0)  # the check is the same whatever the order
    prepared.attrs |= cutter.room()
    log(str(cutter.room()))
    cutter.check(realizations)
    return prepared


def described(walls: dict[str, xr.Dataset]) -> str:
    """Return as JSON the attributes of each rock's scanned walls: files, digests, roughness."""
    about = {
        rock: dict(dataset.attrs) | {str(k): dict(v.attrs) for k, v in dataset.data_vars.items()}
        for rock, dataset in walls.items()
    }
    return json.dumps(about, default=np.generic.item, sort_keys=True)


class Cutter:
    """Cutter of joints with a ``shape`` (ny, nx) from the scanned walls of `prepared_walls`.

    A window is a place at which a joint without missing cells can be cut. Windows are shuffled by
    ``order_seed``, and realisation r has the window at place r of this order, so that added
    realisations do not change the others. ``normalise`` is that of `synthetic_wall`, for a
    synthetic partner.
    """

    def __init__(
        self, walls: xr.Dataset, shape: tuple[int, int], order_seed: int, normalise: str = "wall"
    ):
        self.shape = shape
        self.normalise = normalise
        self.partner = walls.attrs["partner"]
        self.walls = {str(name): wall.values for name, wall in walls.data_vars.items()}
        about = next(iter(walls.data_vars.values())).attrs
        self.drawn = float(about["z2"]), float(walls.attrs["spacing_m"]), float(about["hurst"])
        self.windows = windows(np.sum(list(self.walls.values()), axis=0), shape)
        self.orders = {
            side: generator(seed_of(order_seed, "windows", side)).permutation(len(self.windows))
            for side in ("measured", "partner")
        }

    def check(self, realizations: int) -> None:
        """Raise `InputError` if there are fewer windows than realisations.

        With a synthetic partner any number is allowed, as windows may be used again.
        """
        count = len(self.windows)
        if realizations > count and self.partner != "synthetic":
            raise InputError(
                f"study.realizations = {realizations}: must be at most {count}, the number of "
                f"different joints of {self.shape[0]} x {self.shape[1]} cells that the walls "
                "contain; or use a smaller grid, or synthetic for the other wall"
            )

    def joint(self, realization: int, seed: int) -> dict[str, np.ndarray]:
        """Return the walls (ny, nx) [m] of a realisation by side, each less its plane.

        ``seed`` is that of a synthetic partner.
        """
        origin = self.origin("measured", realization)
        cut = {side: self._cut(wall, origin) for side, wall in self.walls.items()}
        for other in {*SIDES} - set(self.walls):
            if self.partner == "synthetic":
                # the name of the random numbers is a former term: another would change the walls
                random = generator(seed_of(seed, "matching"))
                z2, spacing, hurst = self.drawn
                drawn = z2, self.shape, spacing, Spectrum(hurst), random, self.normalise
                cut[other] = synthetic_wall(*drawn)
            elif self.partner == FLAT:
                cut[other] = np.zeros(self.shape)
            else:
                (wall,) = self.walls.values()
                same = self._cut(wall, self.origin("partner", realization))
                turned = same[::-1, ::-1] if self.partner == "rotated" else same[:, ::-1]
                cut[other] = np.ascontiguousarray(turned)
        return cut

    def origin(self, side: str, realization: int) -> tuple[int, int]:
        """Return the first cell (y, x), in the scan, of the window of a realisation.

        ``side`` is "measured", or "partner" for the window of a rotated or mirrored partner.
        """
        order = self.orders[side]
        y, x = self.windows[order[realization % len(order)]].tolist()
        return y, x

    def room(self) -> dict[str, int]:
        """Return the number of windows, and a number of windows that share no cell.

        These are selected row by row: each window that overlaps none of those selected before.
        """
        count = 0
        left = self.windows
        while len(left):
            left = left[(np.abs(left - left[0]) >= self.shape).any(axis=1)]
            count += 1
        return {"windows": len(self.windows), "windows_side_by_side": count}

    def _cut(self, wall: np.ndarray, origin: tuple[int, int]) -> np.ndarray:
        y, x = origin
        ny, nx = self.shape
        return detrended(wall[y : y + ny, x : x + nx])


def windows(wall: np.ndarray, shape: tuple[int, int]) -> np.ndarray:
    """Return the first cells (k, 2), y and x, of all windows of a shape without missing cells.

    ``wall`` (y, x) has NaN in missing cells. Windows are in the order of rows.

    Raises
    ------
    InputError
        If there is no such window.
    """
    offsets = _full_windows(wall, *shape)
    if not len(offsets):
        size = min(wall.shape)
        while size > 0 and not len(_full_windows(wall, size, size)):
            size -= 1
        raise InputError(
            f"no room for {shape[0]} x {shape[1]} cells (y, x): the wall has {wall.shape[0]} x "
            f"{wall.shape[1]} at the grid's spacing, and its largest full square is {size} x {size}"
        )
    return offsets


def _full_windows(wall: np.ndarray, ny: int, nx: int) -> np.ndarray:
    if wall.shape[0] < ny or wall.shape[1] < nx:
        return np.empty((0, 2), int)
    holes = np.pad(np.cumsum(np.cumsum(~np.isfinite(wall), axis=0), axis=1), ((1, 0), (1, 0)))
    inside = holes[ny:, nx:] - holes[:-ny, nx:] - holes[ny:, :-nx] + holes[:-ny, :-nx]
    return np.argwhere(inside == 0)


def cut_walls(walls: xr.Dataset, settings: ClosureSettings | SurfaceSettings) -> Iterator[tuple]:
    """Generate the walls (upper, lower) of each realisation of a block, cut out of scanned walls.

    ``walls`` is the dataset of `prepared_walls`.
    """
    order = seed_of(settings.root_seed, *settings.seeds_named_by, "windows")
    cutter = Cutter(walls, settings.grid.shape, order, settings.surface.normalise)
    for realization, seed in enumerate(seeds_of(settings), start=settings.first_realization):
        joint = cutter.joint(realization, seed)
        yield joint["upper"], joint["lower"]

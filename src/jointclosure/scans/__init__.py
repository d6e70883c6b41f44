"""Files of scanned walls, read: `read_scan`. They are data, never run nor written to.

numpy, netCDF and text files need nothing beyond the package; STL, TIFF and what surface scanners
write need its extra ``walls``. A reader returns what its file says (`contents.Contents`); units are
settled here.
"""

import functools
import hashlib
from pathlib import Path

import numpy as np

from jointclosure.inputs import InputError
from jointclosure.scans import esri, grids, instruments, meshes, points
from jointclosure.scans.contents import Contents
from jointclosure.scans.sentinels import missing_heights
from jointclosure.scans.units import doubted, settled, size_of
from jointclosure.surface.measured import Cloud, Scan

READERS = {
    ".npy": grids.read_npy,
    ".npz": grids.read_npz,
    ".nc": grids.read_netcdf_grid,
    ".nc4": grids.read_netcdf_grid,
    ".cdf": grids.read_netcdf_grid,
    ".tif": grids.read_tiff,
    ".tiff": grids.read_tiff,
    ".asc": esri.read_asc,
    ".csv": points.read_text,
    ".xyz": points.read_text,
    ".txt": points.read_text,
    ".stl": meshes.read_stl,
}
"""By the end of a file's name; SurfaceTopography is asked for all others."""


def read_scan(
    path: str | Path,
    *,
    units: str | None = None,
    spacing: float | None = None,
    variable: str | None = None,
) -> Scan | Cloud:
    """A scanned wall from a file.

    Parameters
    ----------
    path : path
        The end of its name says its format: see `READERS`.
    units : {"m", "mm", "um", "nm"}, optional
        Of heights and distances, where the file does not say them.
    spacing : float, optional
        Of a grid whose file does not say it [m].
    variable : str, optional
        Which array of an npz or netCDF file, channel of a scanner's file, or three columns of a
        text ("x,y,height", "1,2,4").

    Returns
    -------
    Scan or Cloud
        In metres; its ``remarks`` tell what was missing, stray or passed over.

    Raises
    ------
    InputError
        Naming the file, what is wrong with it, and what is allowed: no such file, a format that
        cannot be read, units that are not stated or contradict the file's.
    """
    path = Path(path)
    if not path.is_file():
        raise InputError(f"{path}: there is no such file")
    reader = READERS.get(path.suffix.lower(), instruments.read_any)
    try:
        found = reader(path, variable)
        return _in_metres(found, units, spacing)
    except InputError as error:
        raise InputError(f"{path}: {error}") from None


def file_digest(path: str | Path) -> str:
    """SHA-256 of a file's contents, computed again where its time or size is another."""
    about = Path(path).stat()
    return _digest(str(path), about.st_mtime_ns, about.st_size)


@functools.cache
def _digest(path: str, changed: int, size: int) -> str:
    with Path(path).open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def _in_metres(found: Contents, units: str | None, spacing: float | None) -> Scan | Cloud:
    sides = _sides(found)
    hint = sides if found.length_units is None else None
    height = size_of(settled("heights", found.height_units, units, hint))
    if found.points is not None:
        if spacing is not None:
            raise InputError(f"spacing = {1e3 * spacing:g} mm: these are points, and no grid")
        return _cloud(found, height, settled("x and y", found.length_units, units, sides), sides)
    steps, origin, remarks = _placed(found, units, spacing, sides)
    heights = _real(found.heights)
    if heights.ndim != 2 or min(heights.shape) < 3:
        raise InputError(f"heights of shape {heights.shape}: must be (y, x), at least 3 x 3")
    missing, missing_said = missing_heights(heights)
    heights[missing] = np.nan
    if not np.isfinite(heights).any():
        raise InputError(f"none of its {heights.size} heights is known: all are missing")
    return Scan(heights * height, steps, origin, found.remarks + remarks + missing_said)


def _cloud(
    found: Contents, height: float, length_units: str, sides: tuple[float, float] | None
) -> Cloud:
    assert found.points is not None  # of points it is asked
    points = found.points[np.isfinite(found.points[:, 2])]
    empty = len(found.points) - len(points)
    remarks = found.remarks + doubted(length_units, sides)
    if empty:
        remarks = (*remarks, f"{empty} points without a height were left out")
    across = size_of(length_units)
    return Cloud(points * np.array([across, across, height]), remarks)


def _placed(
    found: Contents, units: str | None, spacing: float | None, sides: tuple[float, float] | None
) -> tuple[tuple[float, float], tuple[float, float] | None, tuple[str, ...]]:
    """Spacing (dy, dx) and origin (y, x) of a grid [m], and what is odd about its size."""
    if found.spacing is None:
        if spacing is None:
            raise InputError("does not say the spacing of its grid: give it (spacing_mm)")
        length_units, steps, origin = "m", (spacing, spacing), None
        if found.heights is not None and np.ndim(found.heights) == 2:
            sides = _lengths(np.shape(found.heights), steps)
    else:
        length_units = settled("distances", found.length_units, units, sides)
        across = size_of(length_units)
        steps = (float(found.spacing[0]) * across, float(found.spacing[1]) * across)
        origin = found.origin and (found.origin[0] * across, found.origin[1] * across)
        if spacing is not None and any(abs(step - spacing) > 1e-6 * spacing for step in steps):
            own = " and ".join(f"{1e3 * step:g}" for step in dict.fromkeys(steps))
            raise InputError(
                f"spacing = {1e3 * spacing:g} mm: the file says {own} mm; leave it out"
            )
    if not all(np.isfinite(step) and step > 0.0 for step in steps):
        raise InputError(f"spacing {steps}: must be positive")
    return steps, origin, doubted(length_units, sides)


def _sides(found: Contents) -> tuple[float, float] | None:
    """Of the wall along x and y in the file's units; None where they cannot be known."""
    if found.points is not None:
        x, y = np.ptp(found.points[:, :2], axis=0).tolist() if len(found.points) else (0.0, 0.0)
        return x, y
    if found.spacing is None or found.heights is None or np.ndim(found.heights) != 2:
        return None
    return _lengths(np.shape(found.heights), found.spacing)


def _lengths(shape: tuple[int, ...], spacing: tuple[float, float]) -> tuple[float, float]:
    """Of a grid (y, x) along x and y."""
    return spacing[1] * (shape[1] - 1), spacing[0] * (shape[0] - 1)


def _real(values) -> np.ndarray:
    """Values as double precision, NaN where masked or not finite."""
    if np.asarray(values).dtype.kind not in "fiu":
        raise InputError(f"values of type {np.asarray(values).dtype}: must be real numbers")
    numbers = np.array(np.ma.filled(np.ma.asarray(values).astype(float), np.nan))
    numbers[~np.isfinite(numbers)] = np.nan
    return numbers

"""Files of scanned walls: `read_scan`. Files are only read as data, never run or changed.

numpy, netCDF, MATLAB, Surfer and text files need only the package itself. Meshes, TIFF and files of
surface scanners need its extra ``walls``. A reader returns the content of a file
(`contents.Contents`); units are determined here.
"""

import functools
import hashlib
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np

from jointclosure.inputs import InputError
from jointclosure.walls.measured import Cloud, Scan
from jointclosure.walls.scans import esri, grids, instruments, meshes, points, surfer
from jointclosure.walls.scans.contents import (
    LARGEST_FILE,
    SAME_SPACING,
    Contents,
    check_no_variable,
)
from jointclosure.walls.scans.likeness import nearest_form
from jointclosure.walls.scans.sentinels import missing_heights
from jointclosure.walls.scans.units import doubted, settled, size_of

READERS = {
    ".npy": grids.read_npy,
    ".npz": grids.read_npz,
    ".nc": grids.read_netcdf_grid,
    ".nc4": grids.read_netcdf_grid,
    ".cdf": grids.read_netcdf_grid,
    ".tif": grids.read_tiff,
    ".tiff": grids.read_tiff,
    ".csv": points.read_text,
    ".xyz": points.read_text,
    ".txt": points.read_text,
    **dict.fromkeys((".stl", ".ply", ".obj"), meshes.read_mesh),
    ".mat": grids.read_matlab,
}
"""Readers by suffix of a file's name; SurfaceTopography reads all other files."""
_IN_PARTS = (
    grids.read_npy, grids.read_npz, grids.read_netcdf_grid, grids.read_tiff, grids.read_matlab,
)  # fmt: skip
"""Readers that read the declared sizes of a file first, and then only what is needed."""
BY_CONTENT = {b"ncols": esri.read_asc} | dict.fromkeys(surfer.FORMS, surfer.read_grd)
"""Readers by the first bytes of a file, which have priority over its name."""


def read_scan(
    path: str | Path | Sequence[str | Path],
    *,
    units: str | None = None,
    spacing: float | None = None,
    variable: str | None = None,
) -> Scan | Cloud:
    """Read a scanned wall from a file.

    Parameters
    ----------
    path : path, or three paths
        Its first bytes (`BY_CONTENT`) or the suffix of its name (`READERS`) determine the format.
        Three files, as a sequence or as "x.txt,y.txt,z.txt", are matrices of x, y and heights.
    units : {"m", "mm", "um", "nm"}, optional
        Units of heights and distances, if the file does not state them.
    spacing : float, optional
        Spacing of a grid [m], if the file does not state it.
    variable : str, optional
        Name of an array of an npz, netCDF or MATLAB file, of a channel of a scanner's file, or of
        three columns of a text file ("x,y,height", "1,2,4").

    Returns
    -------
    Scan or Cloud
        Scan in metres; its ``remarks`` describe missing, stray and skipped values.

    Raises
    ------
    InputError
        If the file does not exist, its format cannot be read, or units are not stated or
        contradict those of the file. The message names the file, the problem and what is allowed.
    """
    files = files_of(path)
    for file in files:
        if not file.is_file():
            raise InputError(f"{file}: file not found")
        if not file.stat().st_size:
            raise InputError(f"{file}: the file is empty")
        if _reader(file) not in _IN_PARTS and file.stat().st_size > LARGEST_FILE:
            raise InputError(
                f"{file}: {file.stat().st_size / 1e9:.3g} GB: must be at most "
                f"{LARGEST_FILE / 1e9:g} GB for its format, which is read as a whole"
            )
    try:
        contents = (
            _contents(files[0], variable) if len(files) == 1 else _of_matrices(files, variable)
        )
        return _in_metres(contents, units, spacing)
    except InputError as error:
        raise InputError(f"{', '.join(map(str, files))}: {error}") from None
    except MemoryError:
        raise InputError(f"{', '.join(map(str, files))}: needs more memory than there is") from None


def files_of(path: str | Path | Sequence[str | Path]) -> tuple[Path, ...]:
    """Return the file of a scan, or its three files of x, y and heights, as for `read_scan`."""
    if not isinstance(path, str | Path):
        parts = [str(part) for part in path]
    elif Path(path).is_file() or "," not in str(path):
        return (Path(path),)
    else:
        parts = str(path).split(",")
    if len(parts) != 3:
        raise InputError(
            f"{', '.join(parts)}: must be one file, or three files with x, y and heights, as in "
            "x.txt,y.txt,z.txt"
        )
    return Path(parts[0]), Path(parts[1]), Path(parts[2])


def _contents(path: Path, variable: str | None) -> Contents:
    """Read one file; an error also names the form that its content is most like."""
    reader = _reader(path)
    try:
        return reader(path, variable)
    except InputError as error:
        known = reader in BY_CONTENT.values()
        raise InputError(f"{error}{'' if known else nearest_form(path)}") from None


def _reader(path: Path) -> Callable[[Path, str | None], Contents]:
    """Return the reader of a file by its content, otherwise by its name."""
    with path.open("rb") as file:
        start = file.read(64).lstrip().lower()
    readers = (reader for mark, reader in BY_CONTENT.items() if start.startswith(mark.lower()))
    return next(readers, None) or READERS.get(path.suffix.lower(), instruments.read_any)


def _of_matrices(files: tuple[Path, ...], variable: str | None) -> Contents:
    """Read matrices of x, y and heights from three files."""
    check_no_variable(variable)
    parts = []
    for file in files:
        try:
            text = _reader(file) is points.read_text
            parts.append(points.read_matrix(file) if text else _contents(file, None))
        except InputError as error:
            raise InputError(f"{file}: {error}") from None
    return points.joined(*parts)


def file_digest(path: str | Path) -> str:
    """Return the SHA-256 of a scan's content, recomputed if its time or size has changed.

    Of three files it is that of their digests.
    """
    parts = []
    for file in files_of(path):
        about = file.stat()
        parts.append(_digest(str(file), about.st_mtime_ns, about.st_size))
    return parts[0] if len(parts) == 1 else hashlib.sha256("".join(parts).encode()).hexdigest()


@functools.cache
def _digest(path: str, changed: int, size: int) -> str:
    with Path(path).open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def _in_metres(contents: Contents, units: str | None, spacing: float | None) -> Scan | Cloud:
    sides = _sides(contents)
    hint = sides if contents.length_units is None else None
    height = size_of(settled("heights", contents.height_units, units, hint))
    if contents.points is not None:
        if spacing is not None:
            raise InputError(
                f"spacing = {1e3 * spacing:g} mm: must be left out for points, which have no grid"
            )
        return _cloud(
            contents, height, settled("x and y", contents.length_units, units, sides), sides
        )
    steps, origin, remarks = _placed(contents, units, spacing, sides)
    heights = _real(contents.heights)
    if heights.ndim != 2 or min(heights.shape) < 3:
        raise InputError(f"heights of shape {heights.shape}: must be (y, x), at least 3 x 3")
    missing, missing_remarks = missing_heights(heights)
    heights[missing] = np.nan
    if not np.isfinite(heights).any():
        raise InputError(f"all of its {heights.size} heights are missing")
    return Scan(heights * height, steps, origin, contents.remarks + remarks + missing_remarks)


def _cloud(
    contents: Contents, height: float, length_units: str, sides: tuple[float, float] | None
) -> Cloud:
    assert contents.points is not None  # only called for points
    points = contents.points[np.isfinite(contents.points[:, 2])]
    empty = len(contents.points) - len(points)
    remarks = contents.remarks + doubted(length_units, sides)
    if empty:
        remarks = (*remarks, f"{empty} points without a height were left out")
    across = size_of(length_units)
    return Cloud(points * np.array([across, across, height]), remarks)


def _placed(
    contents: Contents, units: str | None, spacing: float | None, sides: tuple[float, float] | None
) -> tuple[tuple[float, float], tuple[float, float] | None, tuple[str, ...]]:
    """Return spacing (dy, dx) and origin (y, x) of a grid [m], and remarks on its size."""
    if contents.spacing is None:
        if spacing is None:
            raise InputError(
                "does not state the spacing of its grid: spacing_mm must be given "
                "(--spacing on the command line)"
            )
        length_units, steps, origin = "m", (spacing, spacing), None
        if contents.heights is not None and np.ndim(contents.heights) == 2:
            sides = _lengths(np.shape(contents.heights), steps)
    else:
        length_units = settled("distances", contents.length_units, units, sides)
        across = size_of(length_units)
        steps = (float(contents.spacing[0]) * across, float(contents.spacing[1]) * across)
        origin = contents.origin and (contents.origin[0] * across, contents.origin[1] * across)
        if spacing is not None and any(
            abs(step - spacing) > SAME_SPACING * spacing for step in steps
        ):
            stated = " and ".join(f"{1e3 * step:g}" for step in dict.fromkeys(steps) if step > 0.0)
            raise InputError(
                f"spacing = {1e3 * spacing:g} mm: the file states {stated} mm; must be left out"
            )
        if spacing is None and np.isnan(steps).any():
            raise InputError(
                f"states a spacing along {'x' if np.isnan(steps[0]) else 'y'} only: spacing_mm "
                "must be given (--spacing on the command line)"
            )
        dy, dx = np.where(np.isnan(steps), spacing or np.nan, steps).tolist()
        steps = dy, dx
    if not all(np.isfinite(step) and step > 0.0 for step in steps):
        raise InputError(f"spacing {steps}: must be positive")
    return steps, origin, doubted(length_units, sides)


def _sides(contents: Contents) -> tuple[float, float] | None:
    """Return the lengths of the wall along x and y in the file's units; None if unknown."""
    if contents.points is not None:
        x, y = (
            np.ptp(contents.points[:, :2], axis=0).tolist() if len(contents.points) else (0.0, 0.0)
        )
        return x, y
    if contents.spacing is None or np.isnan(contents.spacing).any():
        return None
    if contents.heights is None or np.ndim(contents.heights) != 2:
        return None
    return _lengths(np.shape(contents.heights), contents.spacing)


def _lengths(shape: tuple[int, ...], spacing: tuple[float, float]) -> tuple[float, float]:
    """Return the lengths of a grid (y, x) along x and y."""
    return spacing[1] * (shape[1] - 1), spacing[0] * (shape[0] - 1)


def _real(values) -> np.ndarray:
    """Convert values to double precision, NaN where masked or not finite."""
    if np.asarray(values).dtype.kind not in "fiu":
        raise InputError(f"values of type {np.asarray(values).dtype}: must be real numbers")
    numbers = np.array(np.ma.filled(np.ma.asarray(values).astype(float), np.nan))
    numbers[~np.isfinite(numbers)] = np.nan
    return numbers

"""Files of scanned walls: `read_scan`. Files are only read as data, never run or changed."""

import functools
import hashlib
import re
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from jointclosure.inputs import InputError, naming, size_of
from jointclosure.walls.measured import Cloud, Scan
from jointclosure.walls.scans import arrays, points, rasters
from jointclosure.walls.scans.contents import (
    LARGEST_FILE,
    SAME_SPACING,
    Contents,
    check_no_variable,
    doubted,
    missing_heights,
    reading_as,
    settled,
)
from jointclosure.walls.scans.text import is_binary


class Format(NamedTuple):
    """Format of files: title, reader; whether a variable chooses, whether sizes are read first."""

    title: str
    read: Callable[..., Contents]
    named: bool = False
    in_parts: bool = False


_NETCDF = Format("netCDF", arrays.read_netcdf_grid, named=True, in_parts=True)
_TIFF = Format("TIFF", rasters.read_tiff, in_parts=True)
_TEXT = Format("points", points.read_text, named=True)
_SCANNER = Format("a scanner's file", rasters.read_scanner, named=True)
BY_SUFFIX = {
    ".npy": Format("an array of numbers", arrays.read_npy, in_parts=True),
    ".npz": Format("an array of numbers", arrays.read_npz, named=True, in_parts=True),
    **dict.fromkeys((".nc", ".nc4", ".cdf"), _NETCDF),
    **dict.fromkeys((".tif", ".tiff"), _TIFF),
    **dict.fromkeys((".csv", ".xyz", ".txt"), _TEXT),
    **{f".{form}": Format(form.upper(), points.read_mesh) for form in ("stl", "ply", "obj")},
    ".mat": Format(
        "a MATLAB file (up to version 7.2: save with -v7)", arrays.read_matlab, True, True
    ),
}
"""Formats by suffix of a file's name; SurfaceTopography reads all other files."""
BY_CONTENT = {b"ncols": Format("an ESRI grid", rasters.read_esri)} | dict.fromkeys(
    rasters.SURFER, Format("a Surfer grid", rasters.read_surfer)
)
"""Formats by the first bytes of a file, which have priority over its name."""

_STARTS = {
    b"\x93NUMPY": "an array of numpy (.npy)",
    b"PK\x03\x04": "an archive (.npz, a workbook of Excel, .zip)",
    b"\x1f\x8b": "a file compressed by gzip",
    b"\x89HDF": "HDF5 (.nc, .nc4, or MATLAB 7.3: save with -v7)",
    b"CDF": "netCDF (.nc, .cdf)",
    b"MATLAB": "a MATLAB file (.mat)",
    b"ply": "a PLY mesh (.ply)",
    b"solid": "an STL mesh (.stl)",
    b"II*\0": "TIFF (.tif, .tiff)",
    b"MM\0*": "TIFF (.tif, .tiff)",
    b"%PDF": "PDF, which has no heights",
    b"\x89PNG": "a PNG picture, which has no heights",
    b"\xff\xd8\xff": "a JPEG picture, which has no heights",
}
"""What a file that cannot be read is most like, by its first bytes."""
_OBJ = re.compile(rb"^v(\s+[-+.\de]+){3}", re.MULTILINE)
"""Line of an OBJ file that states a vertex."""
_PROBED = 4096
"""Number of bytes by which text is recognised."""


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
        Its first bytes (`BY_CONTENT`) or the suffix of its name (`BY_SUFFIX`) determine the format.
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
        with naming(str(file)):
            _check_file(file)
    with naming(", ".join(map(str, files))):
        try:
            several = len(files) > 1
            contents = _joined(files, variable) if several else _contents(files[0], variable)
            return _in_metres(contents, units, spacing)
        except MemoryError:
            raise InputError("needs more memory than there is") from None


def files_of(path: str | Path | Sequence[str | Path]) -> tuple[Path, ...]:
    """Return the file of a scan, or its three files of x, y and heights, as for `read_scan`."""
    if isinstance(path, str | Path):
        if Path(path).is_file() or "," not in str(path):
            return (Path(path),)
        path = str(path).split(",")
    if len(path) != 3:
        raise InputError(
            f"{', '.join(map(str, path))}: must be one file, or three files with x, y and heights, "
            "as in x.txt,y.txt,z.txt"
        )
    return tuple(map(Path, path))


def _check_file(file: Path) -> None:
    """Raise `InputError` if a file does not exist, is empty, or too large for its format."""
    if not file.is_file():
        raise InputError("file not found")
    size = file.stat().st_size
    if not size:
        raise InputError("the file is empty")
    if size > LARGEST_FILE and not _format_of(file).in_parts:
        raise InputError(
            f"{size / 1e9:.3g} GB: must be at most {LARGEST_FILE / 1e9:g} GB for its format, which "
            "is read as a whole"
        )


def _format_of(path: Path) -> Format:
    """Return the format of a file by its content, otherwise by its name."""
    with path.open("rb") as file:
        start = file.read(64).lstrip().lower()
    formats = (form for mark, form in BY_CONTENT.items() if start.startswith(mark.lower()))
    return next(formats, None) or BY_SUFFIX.get(path.suffix.lower(), _SCANNER)


def _contents(path: Path, variable: str | None) -> Contents:
    """Read one file; an error also names the form that its content is most like."""
    form = _format_of(path)
    try:
        with reading_as(form.title):
            if form.named:
                return form.read(path, variable)
            check_no_variable(variable)
            return form.read(path)
    except InputError as error:
        known = form in BY_CONTENT.values()
        raise InputError(f"{error}{'' if known else _nearest_form(path)}") from None


def _joined(files: tuple[Path, ...], variable: str | None) -> Contents:
    """Read matrices of x, y and heights from three files."""
    check_no_variable(variable)
    parts = []
    for file in files:
        with naming(str(file)):
            text = _format_of(file) is _TEXT
            parts.append(points.read_matrix(file) if text else _contents(file, None))
    return points.joined(*parts)


def _nearest_form(path: Path) -> str:
    """Return the end of an error message: what a file is most like; empty if its name says so."""
    with path.open("rb") as file:
        start = file.read(_PROBED)
    suffix, size = path.suffix.lower(), path.stat().st_size
    marks = (form for mark, form in _STARTS.items() if start.lower().startswith(mark.lower()))
    if form := next(marks, _STARTS[b"solid"] if points.binary_stl_size(start) == size else None):
        return "" if suffix and suffix in form else f"; its content is that of {form}"
    if suffix in (".csv", ".xyz", ".txt", ".obj"):
        return ""
    if _OBJ.search(start):
        return "; its content is that of an OBJ mesh (.obj)"
    text = start.decode("utf-8", errors="replace").isascii() and not is_binary(start)
    if size > LARGEST_FILE or not text:
        return ""
    try:
        with reading_as(_TEXT.title):
            points.read_text(path, None)
    except InputError as error:
        return f"; its content is text; read as points it {error}"
    return "; its content is text with points: rename it to .txt"


def file_digest(path: str | Path) -> str:
    """Return the SHA-256 of a scan's content (of three files, that of their digests)."""
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
    """Return contents in metres, with missing heights as NaN."""
    sides = contents.sides()
    hint = sides if contents.length_units is None else None
    height = size_of(settled("heights", contents.height_units, units, hint))
    if contents.points is not None:
        if spacing is not None:
            given = f"spacing = {1e3 * spacing:g} mm"
            raise InputError(f"{given}: must be left out for points, which have no grid")
        length_units = settled("x and y", contents.length_units, units, sides)
        known = contents.points[np.isfinite(contents.points[:, 2])]
        remarks = contents.remarks + doubted(length_units, sides)
        if empty := len(contents.points) - len(known):
            remarks = (*remarks, f"{empty} points without a height were left out")
        across = size_of(length_units)
        return Cloud(known * np.array([across, across, height]), remarks)
    steps, origin, doubts = _placed(contents, units, spacing)
    heights = _real(contents.heights)
    if heights.ndim != 2 or min(heights.shape) < 3:
        raise InputError(f"heights of shape {heights.shape}: must be (y, x), at least 3 x 3")
    missing, missing_remarks = missing_heights(heights)
    heights[missing] = np.nan
    if not np.isfinite(heights).any():
        raise InputError(f"all of its {heights.size} heights are missing")
    return Scan(heights * height, steps, origin, contents.remarks + doubts + missing_remarks)


def _placed(
    contents: Contents, units: str | None, spacing: float | None
) -> tuple[tuple[float, float], tuple[float, float] | None, tuple[str, ...]]:
    """Return spacing (dy, dx) and origin (y, x) of a grid [m], and remarks on its size."""
    must = "spacing_mm must be given (--spacing on the command line)"
    if contents.spacing is None:
        if spacing is None:
            raise InputError(f"does not state the spacing of its grid: {must}")
        length_units, stated, origin = "m", np.full(2, spacing), None
        contents = contents._replace(spacing=(spacing, spacing))
    else:
        length_units = settled("distances", contents.length_units, units, contents.sides())
        across = size_of(length_units)
        stated = np.array(contents.spacing, dtype=float) * across
        origin = contents.origin and (contents.origin[0] * across, contents.origin[1] * across)
        if spacing is not None and (np.abs(stated - spacing) > SAME_SPACING * spacing).any():
            steps = [f"{1e3 * step:g}" for step in dict.fromkeys(stated.tolist()) if step > 0.0]
            raise InputError(
                f"spacing = {1e3 * spacing:g} mm: the file states {' and '.join(steps)} mm; must "
                "be left out"
            )
        if spacing is None and np.isnan(stated).any():
            raise InputError(
                f"states a spacing along {'x' if np.isnan(stated[0]) else 'y'} only: {must}"
            )
    dy, dx = np.where(np.isnan(stated), spacing or np.nan, stated).tolist()
    if not all(np.isfinite(step) and step > 0.0 for step in (dy, dx)):
        raise InputError(f"spacing {(dy, dx)}: must be positive")
    return (dy, dx), origin, doubted(length_units, contents.sides())


def _real(values) -> np.ndarray:
    """Convert values to double precision, NaN where masked or not finite."""
    if np.asarray(values).dtype.kind not in "fiu":
        raise InputError(f"values of type {np.asarray(values).dtype}: must be real numbers")
    numbers = np.array(np.ma.filled(np.ma.asarray(values).astype(float), np.nan))
    numbers[~np.isfinite(numbers)] = np.nan
    return numbers

"""Files of scanned walls: `read_scan`. Files are only read as data, never run or changed."""

import functools
import hashlib
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from jointclosure.inputs import InputError, check_length, naming
from jointclosure.walls.gridding import Cloud, Scan
from jointclosure.walls.scans import grids, meshes, text
from jointclosure.walls.scans.containment import check_contained
from jointclosure.walls.scans.contents import LARGEST_FILE, Contents, in_metres, reading_as
from jointclosure.walls.scans.points import contents_of


class Format(NamedTuple):
    """Format of scan files, and the function that reads files of this format."""

    title: str  # of the format in messages
    read: Callable[..., Contents]
    named: bool = False  # whether `read` takes the name of a variable besides the path
    in_parts: bool = (
        False  # whether sizes are checked before values are read, so files may be large
    )


# Formats that several suffixes have.
_NETCDF = Format("netCDF", grids.read_netcdf_grid, named=True, in_parts=True)
_TIFF = Format("TIFF", functools.partial(grids.read_raster, driver="GTiff"), in_parts=True)
_TEXT = Format("points", text.read_text_scan, named=True)
_SCANNER = Format("a scanner's file", grids.read_scanner, named=True)
_OTHER_TEXT = Format("points", grids.read_text_or_scanner, named=True)
BY_SUFFIX = {
    ".npy": Format("an array of numbers", grids.read_npy, in_parts=True),
    ".npz": Format("an array of numbers", grids.read_npz, named=True, in_parts=True),
    **dict.fromkeys((".nc", ".nc4", ".cdf"), _NETCDF),
    **dict.fromkeys((".tif", ".tiff"), _TIFF),
    **dict.fromkeys((".csv", ".xyz", ".txt"), _TEXT),
    **{
        f".{form}": Format(form.upper(), meshes.read_mesh, named=True)
        for form in ("stl", "ply", "obj")
    },
    ".mat": Format(
        "a MATLAB file (up to version 7.2: save with -v7)", grids.read_matlab, True, True
    ),
}
"""Formats by the suffix of a file's name. Files with other suffixes are read as text, or as files
of scanners (SurfaceTopography)."""
LONGEST_HEAD = 65_536  # number of first bytes that show whether a file is text or an instrument's
BY_CONTENT = {b"ncols": Format("an ESRI grid", grids.read_esri)} | {
    mark: Format("a Surfer grid", functools.partial(grids.read_raster, driver=name), in_parts=True)
    for mark, name in grids.SURFER.items()
}
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
    **dict.fromkeys((b"II*\0", b"MM\0*"), "TIFF (.tif, .tiff)"),
    b"%PDF": "PDF, which has no heights",
    b"\x89PNG": "a PNG picture, which has no heights",
    b"\xff\xd8\xff": "a JPEG picture, which has no heights",
}
"""Words for messages on files that cannot be read: the format that their first bytes indicate."""


def read_scan(
    path: str | Path | Sequence[str | Path],
    *,
    units: str | None = None,
    scan_spacing: float | None = None,
    variable: str | None = None,
) -> Scan | Cloud:
    """Read a scanned wall from a file.

    Parameters
    ----------
    path : path, or three paths
        Its first bytes (`BY_CONTENT`) or the suffix of its name (`BY_SUFFIX`) determine the format.
        Three files, as a sequence or as "x.txt,y.txt,z.txt", are matrices of x, y and heights.
    units : {"m", "mm", "um", "nm", "inch"}, optional
        Units of heights and distances, if the file does not state them.
    scan_spacing : float, optional
        Spacing of a grid [m], if the file does not state it.
    variable : str, optional
        Name of an array of an npz, netCDF or MATLAB file, of a channel of a scanner's file, or of
        three columns of a text file ("x,y,height", "1,2,4"). For a mesh, the order of coordinates:
        "3,1,2" turns a vertical wall, whose heights lie along y.

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
    if scan_spacing is not None:
        check_length("scan_spacing", scan_spacing)
    files = files_of(path)
    for file in files:
        with naming(str(file)):
            if not file.is_file():
                raise InputError("file not found")
            if not (size := file.stat().st_size):
                raise InputError("the file is empty")
            check_contained(file)
            if size > LARGEST_FILE and not _format_of(file).in_parts:
                most = f"must be at most {LARGEST_FILE / 1e9:g} GB for its format"
                raise InputError(f"{size / 1e9:.3g} GB: {most}, which is read as a whole")
    with naming(", ".join(map(str, files))):
        try:
            if variable is not None and (len(files) > 1 or not _format_of(files[0]).named):
                must = "must be left out; the format has one array without a name"
                raise InputError(f"variable = {variable!r}: {must}")
            contents = (
                _read_three_matrices(files)
                if len(files) > 1
                else _read_contents(files[0], variable)
            )
            return in_metres(contents, units, scan_spacing)
        except MemoryError:
            raise InputError("needs more memory than there is") from None


def files_of(path: str | Path | Sequence[str | Path]) -> tuple[Path, ...]:
    """Return the file of a scan, or its three files of x, y and heights, as for `read_scan`.

    Raise `InputError` for another number of files.
    """
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


def _entry_by_first_bytes(path: Path, marks: dict) -> Any:
    """Return the entry of ``marks`` whose key the file begins with; None if there is none.

    Case and leading blanks are ignored.
    """
    with path.open("rb") as file:
        start = file.read(64).lstrip().lower()
    return next((marks[mark] for mark in marks if start.startswith(mark.lower())), None)


def _format_of(path: Path) -> Format:
    """Return the format of a file by its first bytes, otherwise by the suffix of its name."""
    if form := _entry_by_first_bytes(path, BY_CONTENT):
        return form
    form = BY_SUFFIX.get(path.suffix.lower())
    if form not in (_TEXT, None):
        return form
    with path.open("rb") as file:
        start = file.read(LONGEST_HEAD)
    if grids.INSTRUMENTS.search(start):
        return _SCANNER
    return form or (_OTHER_TEXT if text.is_text(start) else _SCANNER)


def _read_contents(path: Path, variable: str | None = None) -> Contents:
    """Read one scan file by its format.

    An `InputError` also names the format that the first bytes indicate, if it is another one.
    """
    form = _format_of(path)
    suffix = path.suffix.lower()
    try:
        with reading_as(form.title):
            return form.read(path, variable) if form.named else form.read(path)
    except InputError as error:
        like = _entry_by_first_bytes(path, _STARTS)
        if like is None or form in BY_CONTENT.values() or (suffix and suffix in like):
            raise
        raise InputError(f"{error}; its content is that of {like}") from None


def _read_three_matrices(files: tuple[Path, ...]) -> Contents:
    """Read three files of matrices (y, x): places x, places y, and heights.

    Raise `InputError` if their shapes differ.
    """
    parts = []
    for file in files:
        with naming(str(file)):
            as_text = _format_of(file) in (_TEXT, _OTHER_TEXT)
            parts.append(text.read_matrix(file) if as_text else _read_contents(file))
    matrices = [np.asarray(part.heights, dtype=float) for part in parts]
    if len({matrix.shape for matrix in matrices}) > 1:
        listed = ", ".join(" x ".join(map(str, matrix.shape)) for matrix in matrices)
        raise InputError(f"matrices of {listed} (rows x columns): must be equal for x, y and z")
    columns = np.stack([matrix.ravel() for matrix in matrices], axis=1)
    remarks = [remark for part in parts for remark in part.remarks]
    return contents_of(columns, [part.height_units for part in parts], tuple(remarks))


def file_digest(path: str | Path) -> str:
    """Return the SHA-256 of the content of a scan's file, in hexadecimal digits.

    For three files it is the SHA-256 of their three digests, one after the other.
    """
    parts = [_digest(file, file.stat().st_mtime_ns) for file in files_of(path)]
    return parts[0] if len(parts) == 1 else hashlib.sha256("".join(parts).encode()).hexdigest()


@functools.cache
def _digest(path: Path, changed: int) -> str:
    """Return the SHA-256 of a file; ``changed`` is when, so that a changed file is read again."""
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()

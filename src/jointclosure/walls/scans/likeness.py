"""Form that a file which cannot be read is most like, by its first bytes."""

import re
from pathlib import Path

from jointclosure.inputs import InputError
from jointclosure.walls.scans.contents import LARGEST_FILE
from jointclosure.walls.scans.meshes import binary_stl_size
from jointclosure.walls.scans.points import read_text
from jointclosure.walls.scans.text import is_binary

_STL = "an STL mesh (.stl)"
_STARTS = {
    b"\x93NUMPY": "an array of numpy (.npy)",
    b"PK\x03\x04": "an archive (.npz, a workbook of Excel, .zip)",
    b"\x1f\x8b": "a file compressed by gzip",
    b"\x89HDF": "HDF5 (.nc, .nc4, or MATLAB 7.3: save with -v7)",
    b"CDF": "netCDF (.nc, .cdf)",
    b"MATLAB": "a MATLAB file (.mat)",
    b"ply": "a PLY mesh (.ply)",
    b"solid": _STL,
    b"II*\0": "TIFF (.tif, .tiff)",
    b"MM\0*": "TIFF (.tif, .tiff)",
    b"%PDF": "PDF, which has no heights",
    b"\x89PNG": "a PNG picture, which has no heights",
    b"\xff\xd8\xff": "a JPEG picture, which has no heights",
}
"""Forms by the first bytes of a file."""
_OBJ = re.compile(rb"^v(\s+[-+.\de]+){3}", re.MULTILINE)
"""Line of an OBJ file that states a vertex."""
_PROBED = 4096
"""Number of bytes by which text is recognised."""


def nearest_form(path: Path) -> str:
    """Return the end of an error message: what a file is most like, and what is wrong with it.

    Empty where the form follows from the name, or is not known.
    """
    with path.open("rb") as file:
        start = file.read(_PROBED)
    suffix = path.suffix.lower()
    if form := _known_form(start, path.stat().st_size):
        return "" if suffix and suffix in form else f"; its content is that of {form}"
    if suffix in (".csv", ".xyz", ".txt", ".obj"):
        return ""
    if _OBJ.search(start):
        return "; its content is that of an OBJ mesh (.obj)"
    if path.stat().st_size > LARGEST_FILE:
        return ""
    if is_binary(start) or not start.decode("utf-8", errors="replace").isascii():
        return ""
    try:
        read_text(path, None)
    except InputError as error:
        return f"; its content is text; read as points it {error}"
    return "; its content is text with points: rename it to .txt"


def _known_form(start: bytes, size: int) -> str | None:
    """Return the form of a file of a size [bytes] by its first bytes; None if it is not known."""
    for mark, form in _STARTS.items():
        if start.lower().startswith(mark.lower()):
            return form
    return _STL if binary_stl_size(start) == size else None

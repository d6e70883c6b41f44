"""Heights on a regular grid in files of rasters: ESRI, Surfer, TIFF and surface scanners."""

import struct
from pathlib import Path

import numpy as np

from jointclosure.inputs import InputError, check_one_of
from jointclosure.inputs.extras import needs
from jointclosure.walls.scans.contents import Contents, check_size, incomplete, reading_as

_NEEDED = ("ncols", "nrows")
_PLACES = ("xllcorner", "yllcorner", "xllcenter", "yllcenter")
_KNOWN = (*_NEEDED, "cellsize", "dx", "dy", *_PLACES, "nodata_value")
"""Words of the header of an ESRI grid."""
_BLANK = 1.70141e38
"""Heights of a Surfer grid from this value on are missing."""
_METRE, _LINEAR, _VERTICAL = 9001, "ProjLinearUnitsGeoKey", "VerticalUnitsGeoKey"


def read_esri(path: Path) -> Contents:
    """Read an ESRI ASCII grid: a header of words and numbers, then rows from the largest y down."""
    lines = [line.split() for line in path.read_text(encoding="latin-1").splitlines()]
    words = [word for line in lines for word in line]
    head: dict[str, float] = {}
    while 2 * len(head) + 1 < len(words) and words[2 * len(head)].lower() in _KNOWN:
        key, value = words[2 * len(head)].lower(), words[2 * len(head) + 1]
        if key in head:
            raise InputError(f"{key}: must be only once in the header")
        try:
            head[key] = float(value)
        except ValueError:
            raise InputError(f"{key} = {value!r}: must be a number") from None
    if missing := [key for key in _NEEDED if key not in head]:
        raise InputError(f"its header lacks {', '.join(missing)}")
    step = _cell_size(head)
    rows, columns = _count("nrows", head), _count("ncols", head)
    check_size((rows, columns))
    _check_rows([len(line) for line in lines if line and line[0].lower() not in _KNOWN], columns)
    values = words[2 * len(head) :]
    if len(values) != rows * columns:
        raise incomplete(rows, columns, len(values))
    try:
        heights = np.array(values, dtype=float).reshape(rows, columns)[::-1].copy()
    except ValueError as error:
        raise InputError(f"has a height that is not a number ({error})") from None
    heights[heights == head.get("nodata_value", -9999.0)] = np.nan
    # the middle of the first cell, if the file places it
    places = [
        head.get(f"{axis}llcenter", head.get(f"{axis}llcorner", np.nan) + 0.5 * step)
        for axis in "yx"
    ]
    origin = None if np.isnan(places).any() else (places[0], places[1])
    return Contents(heights, (step, step), origin=origin)


def _check_rows(counts: list[int], columns: int) -> None:
    """Raise `InputError` if most lines are a row and others have more or fewer heights."""
    wrong = [row for row, count in enumerate(counts, start=1) if count != columns]
    if wrong and len(wrong) <= 0.5 * len(counts):
        raise InputError(
            f"row {wrong[0]} contains {counts[wrong[0] - 1]} heights, must be {columns} "
            f"({len(wrong)} such rows)"
        )


def _cell_size(head: dict[str, float]) -> float:
    """Return the cell size, or equal dx and dy in its place, as GDAL writes them."""
    sizes = {key: head[key] for key in ("dx", "dy", "cellsize") if key in head}
    if sizes.keys() in ({"dx"}, {"dy"}, set()):
        raise InputError("its header lacks cellsize")
    first = next(iter(sizes.values()))
    if any(abs(size - first) > 1e-6 * abs(first) for size in sizes.values()):
        listed = ", ".join(f"{key} = {size:g}" for key, size in sizes.items())
        raise InputError(f"{listed}: must be equal, because an ESRI grid has square cells")
    return first


def _count(key: str, head: dict[str, float]) -> int:
    if not (head[key] >= 1.0 and head[key].is_integer()):
        raise InputError(f"{key} = {head[key]:g}: must be a whole number of at least 1")
    return int(head[key])


def read_surfer(path: Path) -> Contents:
    """Read a Surfer grid of version 6 (text DSAA, binary DSBB) or 7 (DSRB), from the least y up."""
    content = path.read_bytes()
    (nx, ny, (x, x_end), (y, y_end)), heights = SURFER[content[:4]](content)
    if min(nx, ny) < 2:
        raise InputError(f"declares {ny} rows of {nx} heights: must be at least 2 of 2")
    if heights.size != nx * ny:
        raise incomplete(ny, nx, heights.size)
    heights = np.where(heights >= 0.999 * _BLANK, np.nan, heights).reshape(ny, nx)
    spacing = (y_end - y) / (ny - 1), (x_end - x) / (nx - 1)
    return Contents(heights, spacing, origin=(y, x))


def _surfer_text(content: bytes) -> tuple[tuple, np.ndarray]:
    """Return (nx, ny, x limits, y limits) and the heights in the order of the file."""
    words = content.split()
    nx, ny = int(words[1]), int(words[2])
    check_size((ny, nx))
    limits = [float(word) for word in words[3:7]]
    return (nx, ny, limits[:2], limits[2:]), np.array(words[9:], dtype=float)


def _surfer_binary(content: bytes) -> tuple[tuple, np.ndarray]:
    """Return the same of a binary grid."""
    nx, ny, *limits = struct.unpack_from("<2h4d", content, 4)
    check_size((ny, nx))
    start = 4 + struct.calcsize("<2h6d")
    heights = np.frombuffer(content[start : start + 4 * nx * ny], dtype="<f4").astype(float)
    return (nx, ny, limits[:2], limits[2:]), heights


def _surfer_sections(content: bytes) -> tuple[tuple, np.ndarray]:
    """Return the same of version 7; heights from its blank value on, or equal to it, are NaN."""
    sections, start = {}, 0
    while start + 8 <= len(content):
        name, size = struct.unpack_from("<4si", content, start)
        if size < 0:
            raise InputError(f"section {name!r}: must have a size of at least 0 bytes")
        sections[name] = content[start + 8 : start + 8 + size]
        start += 8 + size
    if missing := {b"GRID", b"DATA"} - sections.keys():
        raise InputError(f"lacks the section {', '.join(sorted(map(bytes.decode, missing)))}")
    ny, nx, x, y, dx, dy, *_, angle, blank = struct.unpack_from("<2i8d", sections[b"GRID"])
    if angle != 0.0:
        raise InputError(f"rotation = {angle:g} degrees: must be 0, a grid along x and y")
    check_size((ny, nx))
    heights = np.frombuffer(sections[b"DATA"][: 8 * nx * ny], dtype="<f8").copy()
    exact = struct.unpack_from("<i", sections[b"DSRB"]) == (2,)
    heights[heights == blank if exact else heights >= blank] = np.nan
    return (nx, ny, (x, x + (nx - 1) * dx), (y, y + (ny - 1) * dy)), heights


SURFER = {b"DSAA": _surfer_text, b"DSBB": _surfer_binary, b"DSRB": _surfer_sections}
"""Readers of Surfer grids by the first bytes of a file."""


def read_tiff(path: Path) -> Contents:
    """Read the first page of a TIFF; of a GeoTIFF also pixel size, units and missing value."""
    with needs("walls", "TIFF"):
        import tifffile
    with tifffile.TiffFile(path) as file:
        page = file.pages.first
        check_size(page.shape, np.dtype(page.dtype).itemsize)
        heights, geo = page.asarray(), page.geotiff_tags or {}
        nothing = page.tags.valueof("GDAL_NODATA")
    if heights.ndim != 2 or heights.dtype.kind not in "fiu":
        raise InputError(f"has an image {heights.shape} of {heights.dtype}: must be heights (y, x)")
    heights = heights.astype(float)
    if (value := _no_data(nothing)) is not None:
        heights[heights == value] = np.nan
    spacing = origin = None
    if "ModelPixelScale" in geo:
        dx, dy = (float(value) for value in geo["ModelPixelScale"][:2])
        spacing, heights = (dy, dx), heights[::-1]
        tie = geo.get("ModelTiepoint")
        if tie is not None and len(tie) == 6:  # exactly one: places the last row, of least y
            column, row, _, x, y, _ = (float(value) for value in tie)
            origin = y - (len(heights) - 1 - row) * dy, x - column * dx
    units = {
        key: "m" if int(geo[key]) == _METRE else f"EPSG unit {int(geo[key])}"
        for key in (_LINEAR, _VERTICAL)
        if key in geo
    }
    return Contents(heights, spacing, None, units.get(_VERTICAL), units.get(_LINEAR), origin)


def _no_data(written) -> float | None:
    """Return the value of pixels without a height, None if the file declares none."""
    word = str("" if written is None else written).strip("\0 ")
    if word.lower() in ("", "none", "null"):
        return None
    try:
        return float(word)
    except ValueError:
        raise InputError(f"GDAL_NODATA = {word!r}: must be a number or none") from None


def read_scanner(path: Path, variable: str | None) -> Contents:
    """Read a channel of a scanner's file, by default its default one, by SurfaceTopography."""
    with needs("walls", f"{path.suffix or 'a file without suffix'}: a scanner's format"):
        from SurfaceTopography.Exceptions import CannotDetectFileFormat
        from SurfaceTopography.IO import open_topography
    with reading_as("a scanner's file"):
        try:
            opened = open_topography(str(path))
        except CannotDetectFileFormat:  # its message has the errors of all readers
            raise InputError("is of no form that is read here") from None
    with opened as reader:
        channel, index = reader.default_channel, None
        if variable is not None:
            names = [channel.name for channel in reader.channels]
            check_one_of("variable", variable, tuple(names))
            index = names.index(variable)
            channel = reader.channels[index]
        check_size(tuple(channel.nb_grid_pts))
        sized = channel.physical_sizes is not None
        given = {} if sized else {"physical_sizes": tuple(channel.nb_grid_pts)}
        surface = reader.topography(channel_index=index, **given)
        if surface.dim != 2:
            raise InputError("contains a profile, must be a surface")
        heights = np.ma.filled(np.ma.asarray(surface.heights()).astype(float), np.nan)
        pixels, units = surface.pixel_size, surface.unit
    # SurfaceTopography's arrays are (x, y)
    spacing = (float(pixels[1]), float(pixels[0])) if sized else None
    return Contents(heights.T, spacing, None, units, units)

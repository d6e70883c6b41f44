"""Heights on a regular grid: npy, npz, netCDF, MATLAB, TIFF and GeoTIFF. Arrays are (y, x)."""

import re
import struct
import zipfile
import zlib
from functools import partial
from pathlib import Path
from typing import IO

import netCDF4
import numpy as np
import scipy

from jointclosure.inputs import InputError
from jointclosure.inputs.extras import needs
from jointclosure.walls.scans.arrays import Array, chosen, grid_of
from jointclosure.walls.scans.contents import Contents, check_no_variable, check_size, reading_as
from jointclosure.walls.scans.units import split_name

_ARRAYS = "an array of numbers"
_METRE, _LINEAR, _VERTICAL = 9001, "ProjLinearUnitsGeoKey", "VerticalUnitsGeoKey"


def read_npy(path: Path, variable: str | None) -> Contents:
    """Read one array, without units or spacing."""
    check_no_variable(variable)
    with reading_as(_ARRAYS), path.open("rb") as file:
        if _start(file).startswith(b"PK"):
            raise InputError("is an archive of arrays, not a single array; rename it to .npz")
        return Contents(heights=_array(file))


def read_npz(path: Path, variable: str | None) -> Contents:
    """Read an array of an archive, placed by the others (`arrays.grid_of`)."""
    with reading_as(_ARRAYS), path.open("rb") as file:
        if _start(file) == np.lib.format.MAGIC_PREFIX:
            raise InputError("is a single array, not an archive; rename it to .npy")
        with zipfile.ZipFile(file) as archive:
            arrays = {}
            for member in archive.namelist():
                with archive.open(member) as content:
                    shape, kind = _head(content)
                name = member.removesuffix(".npy")
                load = partial(_member, archive, member)
                arrays[name] = Array(shape, kind, split_name(name)[1], load)
            return grid_of(arrays, variable)


def _member(archive: zipfile.ZipFile, member: str) -> np.ndarray:
    """Read an array of an archive."""
    with archive.open(member) as content:
        return _array(content)


def _start(file: IO[bytes]) -> bytes:
    """Return the first bytes of a file, which identify its format."""
    start = file.read(len(np.lib.format.MAGIC_PREFIX))
    file.seek(0)
    return start


def _head(file: IO[bytes]) -> tuple[tuple[int, ...], np.dtype]:
    """Return the shape and type that the header of an array declares."""
    version = np.lib.format.read_magic(file)
    read = np.lib.format.read_array_header_1_0
    shape, _, kind = (read if version == (1, 0) else np.lib.format.read_array_header_2_0)(file)
    return shape, kind


def _array(file: IO[bytes]) -> np.ndarray:
    """Read an array up to the largest size; pickles are refused."""
    shape, kind = _head(file)
    check_size(shape, kind.itemsize)
    file.seek(0)
    return np.lib.format.read_array(file, allow_pickle=False)


def read_netcdf_grid(path: Path, variable: str | None) -> Contents:
    """Read a variable over y and x by the names of its dimensions, with units from its attribute.

    It is placed by its coordinates (`arrays.grid_of`). Values that are missing, or not valid by the
    attributes of the CF conventions, are NaN.
    """
    with reading_as("netCDF", OSError, ValueError), netCDF4.Dataset(path) as dataset:
        variables = dataset.variables
        name = chosen(variable, {key: _netcdf_array(read) for key, read in variables.items()})
        dimensions = variables[name].dimensions
        if len(dimensions) != 2:
            raise InputError(f"variable {name!r} has dimensions {dimensions}: must be over (y, x)")
        axes = [_axis_of(dimension, variables) for dimension in dimensions]
        remarks: tuple[str, ...] = ()
        if not any(axes):
            remarks = (f"dimensions {', '.join(dimensions)}: no name of an axis; read as y, x",)
        elif axes[0] == axes[1]:
            raise InputError(f"dimensions {dimensions}: must be y and x, both are {axes[0]}")
        turned = axes[0] == "x" or axes[1] == "y"
        arrays = {
            key: _netcdf_array(read, turned)
            for key, read in variables.items()
            if set(read.dimensions) <= set(dimensions)
        }
        of_axis = dict(zip(dimensions, "xy" if turned else "yx", strict=True))
        contents = grid_of(arrays, name, of_axis)
    return contents._replace(remarks=remarks + contents.remarks)


def _netcdf_array(variable: netCDF4.Variable, turned: bool = False) -> Array:
    """Return a variable that is not yet read, a matrix transposed if it is turned."""
    units = getattr(variable, "units", None) or split_name(variable.name)[1]
    kind = np.dtype(variable.dtype)
    if turned:
        return Array(variable.shape[::-1], kind, units, lambda: variable[...].T)
    return Array(variable.shape, kind, units, lambda: variable[...])


_AXES = {
    "y": ("y", "lat", "latitude", "northing", "row", "rows", "projection_y_coordinate"),
    "x": ("x", "lon", "longitude", "easting", "column", "columns", "projection_x_coordinate"),
}
"""Names of dimensions, and standard names of coordinates, that identify an axis."""


def _axis_of(dimension: str, variables: dict[str, netCDF4.Variable]) -> str | None:
    """Return the axis of a dimension by its name and its coordinate's attributes, or None."""
    about = variables.get(dimension)
    words = (
        *(getattr(about, key, None) for key in ("axis", "standard_name")),
        split_name(dimension)[0],
    )
    for word in (str(word).lower() for word in words if word):
        for axis, names in _AXES.items():
            if word in names:
                return axis
    return None


def read_tiff(path: Path, variable: str | None) -> Contents:
    """Read the first page of a TIFF; of a GeoTIFF also pixel size, units and missing value."""
    check_no_variable(variable)
    with needs("walls", "TIFF"):
        import tifffile
    with reading_as("TIFF"), tifffile.TiffFile(path) as file:
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
        across, down = (float(value) for value in geo["ModelPixelScale"][:2])
        spacing = (down, across)
        origin = _last_row(geo.get("ModelTiepoint"), spacing, len(heights))
        heights = heights[::-1]
    units = {
        key: "m" if int(geo[key]) == _METRE else f"EPSG unit {int(geo[key])}"
        for key in (_LINEAR, _VERTICAL)
        if key in geo
    }
    return Contents(heights, spacing, None, units.get(_VERTICAL), units.get(_LINEAR), origin)


def _last_row(tie, spacing: tuple[float, float], rows: int) -> tuple[float, float] | None:
    """Return (y, x) of the first pixel of a GeoTIFF's last row, with the smallest y.

    It is computed from the tie point; None unless there is exactly one.
    """
    if tie is None or len(tie) != 6:
        return None
    column, row, _, x, y, _ = (float(value) for value in tie)
    return y - (rows - 1 - row) * spacing[0], x - column * spacing[1]


def _no_data(written) -> float | None:
    """Return the value of pixels without a height, None if the file declares none."""
    word = str("" if written is None else written).strip("\0 ")
    if word.lower() in ("", "none", "null"):
        return None
    try:
        return float(word)
    except ValueError:
        raise InputError(f"GDAL_NODATA = {word!r}: must be a number or none") from None


def read_matlab(path: Path, variable: str | None) -> Contents:
    """Read an array of a MATLAB file up to version 7.2, placed by the others (`arrays.grid_of`).

    Of structs and cells only the one that the variable names is read, or all without a variable.
    """
    with reading_as("a MATLAB file (up to version 7.2: save with -v7)"):
        arrays: dict[str, Array] = {}
        asked = re.split(r"[.({]", variable or "")[0]
        for (name, shape, kind), size in zip(*_listed(path), strict=True):
            load = partial(_matlab_array, path, name)
            if kind in ("struct", "cell") and asked in ("", name):
                check_size((size,), 1, name)
                arrays |= _leaves({name: load()})
            elif kind in ("double", "single", "logical") or "int" in kind:
                number = np.dtype(bool if kind == "logical" else kind)
                arrays[name] = Array(shape, number, split_name(name)[1], load)
        return grid_of(arrays, variable)


def _matlab_array(path: Path, name: str) -> np.ndarray:
    """Read one variable of a MATLAB file."""
    return scipy.io.loadmat(path, variable_names=[name])[name]


def _listed(path: Path) -> tuple[list[tuple], list[int]]:
    """Return name, shape and class of each variable of a MATLAB file, and its size [bytes].

    Of compressed variables it is the size when they are unpacked.
    """
    listed, sizes = scipy.io.whosmat(path), []
    if scipy.io.matlab.matfile_version(path)[0] == 0:  # version 4 has only arrays
        return listed, [0] * len(listed)
    with path.open("rb") as file:
        file.seek(126)
        order = "<" if file.read(2) == b"IM" else ">"
        while len(tag := file.read(8)) == 8:
            kind, size = struct.unpack(f"{order}2I", tag)
            end = file.tell() + size
            if kind == _COMPRESSED:
                start = zlib.decompressobj().decompress(file.read(min(size, 1024)), 8)
                size = struct.unpack(f"{order}2I", start)[1]
            sizes.append(size)
            file.seek(end)
    return listed, sizes


_COMPRESSED = 15
"""Type of an element of a MATLAB file that is compressed."""


def _leaves(values: dict) -> dict[str, Array]:
    """Return arrays of numbers of a MATLAB file by name; those within as S.Z, S(2).Z or C{2}."""
    leaves: dict[str, Array] = {}
    for name, array in values.items():
        if not isinstance(array, np.ndarray):
            continue
        if array.dtype.names is not None:
            for number, struct_ in enumerate(array.ravel(), start=1):
                of_struct = name if array.size == 1 else f"{name}({number})"
                leaves |= _leaves({f"{of_struct}.{key}": struct_[key] for key in array.dtype.names})
        elif array.dtype.kind == "O":
            cells = enumerate(array.ravel(), start=1)
            leaves |= _leaves({f"{name}{{{number}}}": cell for number, cell in cells})
        elif array.dtype.kind in "iufc":
            units = split_name(name.rpartition(".")[2])[1]
            leaves[name] = Array(array.shape, array.dtype, units, partial(np.asarray, array))
    return leaves

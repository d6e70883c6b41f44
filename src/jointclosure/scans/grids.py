"""Heights on a regular grid: npy, npz, netCDF, MATLAB, TIFF and GeoTIFF.

Arrays are (y, x), row by row. In npz files and text headers a name may end with its unit, as
everywhere in this project: ``Z_mm``, ``spacing_mm``.
"""

import itertools
import zipfile
from pathlib import Path
from typing import IO

import numpy as np
import scipy
import xarray as xr

from jointclosure.inputs import InputError
from jointclosure.inputs.extras import needs
from jointclosure.scans.contents import (
    VARIABLE,
    Contents,
    check_no_variable,
    check_size,
    reading_as,
)
from jointclosure.scans.frames import points_on
from jointclosure.scans.points import contents_of
from jointclosure.scans.units import split_name

_ARRAYS = "an array of numbers"
_SPACINGS = ("spacing", "h", "dx")
_METRE, _LINEAR, _VERTICAL = 9001, "ProjLinearUnitsGeoKey", "VerticalUnitsGeoKey"


def read_npy(path: Path, variable: str | None) -> Contents:
    """Read one array, without units or spacing."""
    check_no_variable(variable)
    with reading_as(_ARRAYS), path.open("rb") as file:
        if _start(file).startswith(b"PK"):
            raise InputError("is an archive of arrays, not a single array; rename it to .npz")
        return Contents(heights=_array(file))


def read_npz(path: Path, variable: str | None) -> Contents:
    """Read an array of an archive; its spacing is a number ``spacing``, ``h`` or ``dx``.

    Only the headers of the other arrays are read.
    """
    with reading_as(_ARRAYS), path.open("rb") as file:
        if _start(file) == np.lib.format.MAGIC_PREFIX:
            raise InputError("is a single array, not an archive; rename it to .npy")
        with zipfile.ZipFile(file) as archive:
            members = {name.removesuffix(".npy"): name for name in archive.namelist()}
            shapes = {}
            for key, name in members.items():
                with archive.open(name) as member:
                    shapes[key] = _head(member)[0]
            fields = [key for key, shape in shapes.items() if len(shape) == 2]
            name = _chosen(variable, fields, members)
            steps = [
                key
                for key, shape in shapes.items()
                if split_name(key)[0] in _SPACINGS and shape == ()
            ]
            arrays = {}
            for key in (name, *steps[:1]):
                with archive.open(members[key]) as member:
                    arrays[key] = _array(member)
    height_units = split_name(name)[1]
    for key in steps[:1]:
        value = arrays[key]
        if value.dtype.kind not in "fiu":
            raise InputError(f"{key} = {value.item()!r}: must be a number")
        step = float(value)
        return Contents(arrays[name], (step, step), None, height_units, split_name(key)[1])
    return Contents(arrays[name], None, None, height_units)


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
    shape, _ = _head(file)
    check_size(shape)
    file.seek(0)
    return np.lib.format.read_array(file, allow_pickle=False)


def read_netcdf_grid(path: Path, variable: str | None) -> Contents:
    """Read a variable over y and x by the names of its dimensions, with units from its attribute.

    Spacing and origin are those of its coordinates.
    """
    # a file from outside, which has no seal of this project
    with (
        reading_as("netCDF", OSError, ValueError),
        xr.open_dataset(path, engine="netcdf4", cache=False) as dataset,
    ):
        fields = [str(name) for name, field in dataset.data_vars.items() if field.ndim == 2]
        name = _chosen(variable, fields, {str(key): None for key in dataset.variables})
        check_size(dataset[name].shape)
        field = dataset[name].load()
    if field.ndim != 2:
        raise InputError(f"variable {name!r} has dimensions {field.dims}: must be over (y, x)")
    axes = [_axis_of(field, str(dimension)) for dimension in field.dims]
    remarks: tuple[str, ...] = ()
    if not any(axes):
        listed = ", ".join(map(str, field.dims))
        remarks = (f"dimensions {listed}: no name of an axis; read as y, x",)
    elif axes[0] == axes[1]:
        raise InputError(f"dimensions {field.dims}: must be y and x, both are {axes[0]}")
    elif axes[0] == "x" or axes[1] == "y":
        field = field.transpose()
    coordinates = [field[dimension] for dimension in field.dims if dimension in field.coords]
    spacing = length_units = origin = None
    if len(coordinates) == 2:
        along_y, along_x = (_step(str(c.name), c.values) for c in coordinates)
        spacing = along_y, along_x
        written = {c.attrs.get("units") or split_name(str(c.name))[1] for c in coordinates}
        if len(written) > 1:
            raise InputError(f"the coordinates are in different units: {written}")
        length_units = written.pop()
        growing = {str(c.name): slice(None, None, -1 if c[-1] < c[0] else 1) for c in coordinates}
        field = field.isel(growing)
        origin = (float(field[field.dims[0]][0]), float(field[field.dims[1]][0]))
    height_units = field.attrs.get("units") or split_name(name)[1]
    return Contents(field.values, spacing, None, height_units, length_units, origin, remarks)


_AXES = {
    "y": ("y", "lat", "latitude", "northing", "row", "rows", "projection_y_coordinate"),
    "x": ("x", "lon", "longitude", "easting", "column", "columns", "projection_x_coordinate"),
}
"""Names of dimensions, and standard names of coordinates, that identify an axis."""


def _axis_of(field: xr.DataArray, dimension: str) -> str | None:
    """Return the axis of a dimension by its name and its coordinate's attributes, or None."""
    about = field[dimension].attrs if dimension in field.coords else {}
    words = (about.get("axis"), about.get("standard_name"), split_name(dimension)[0])
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
        check_size(page.shape)
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
    """Read an array of a MATLAB file up to version 7.2; its spacing as in an npz file.

    Matrices X and Y of the places, as from ``meshgrid``, or vectors of them, state the spacing too.
    Fields of structs have names such as S.Z; spacing and places are fields of the same struct.
    """
    with reading_as("a MATLAB file (up to version 7.2: save with -v7)"):
        listed = {name: shape for name, shape, _ in scipy.io.whosmat(path)}
        for shape in listed.values():
            check_size(shape)
        loaded = scipy.io.loadmat(path)
    arrays = _leaves({name: loaded[name] for name in listed})
    fields = [
        name
        for name, array in arrays.items()
        if array.ndim == 2 and min(array.shape) > 2 and _quantity(name) not in ("x", "y")
    ]
    name = _chosen(variable, fields, arrays)
    heights, unit = arrays[name], split_name(name)[1]
    struct = name.rpartition(".")[0]
    beside = {key: value for key, value in arrays.items() if key.rpartition(".")[0] == struct}
    for key, value in beside.items():
        if _quantity(key) in _SPACINGS and value.size == 1:
            step = float(value.item())
            return Contents(heights, (step, step), None, unit, split_name(key)[1])
    placed = _placed(beside, heights)
    if placed is None:
        return Contents(heights, None, None, unit)
    points, length_units = placed
    return contents_of(points)._replace(height_units=unit, length_units=length_units)


def _leaves(arrays: dict) -> dict[str, np.ndarray]:
    """Return arrays of numbers of a MATLAB file by name; those within as S.Z, S(2).Z or C{2}."""
    leaves: dict[str, np.ndarray] = {}
    for name, array in arrays.items():
        if not isinstance(array, np.ndarray):
            continue
        if array.dtype.names is not None:
            for number, struct in enumerate(array.ravel(), start=1):
                of_struct = name if array.size == 1 else f"{name}({number})"
                leaves |= _leaves({f"{of_struct}.{key}": struct[key] for key in array.dtype.names})
        elif array.dtype.kind == "O":
            cells = enumerate(array.ravel(), start=1)
            leaves |= _leaves({f"{name}{{{number}}}": cell for number, cell in cells})
        elif array.dtype.kind in "biufc":
            leaves[name] = array
    return leaves


def _quantity(name: str) -> str:
    """Return the name of an array in lower case, without its struct and its unit."""
    return split_name(name.rpartition(".")[2])[0].lower()


def _placed(
    arrays: dict[str, np.ndarray], heights: np.ndarray
) -> tuple[np.ndarray, str | None] | None:
    """Return points (n, 3) of heights at places named x and y, and the unit of these; or None.

    Of heights (x, y) the places are vectors, as from ``ndgrid``.
    """
    of_axes = ([key for key in arrays if _quantity(key) == axis] for axis in "xy")
    for names in itertools.product(*of_axes):
        x, y = (np.asarray(arrays[name], dtype=float) for name in names)
        vectors = min(x.shape) == min(y.shape) == 1
        if x.shape == y.shape == heights.shape:
            points = np.stack([x.ravel(), y.ravel(), heights.ravel()], axis=1)
        elif vectors and (y.size, x.size) == heights.shape:
            points = points_on(x.ravel(), y.ravel(), heights)
        elif vectors and (x.size, y.size) == heights.shape:
            points = points_on(x.ravel(), y.ravel(), heights.T)
        else:
            continue
        units = {split_name(name)[1] for name in names}
        if len(units) > 1:
            raise InputError(f"{' and '.join(names)}: must be in the same units")
        return points, units.pop()
    return None


def _chosen(variable: str | None, fields: list[str], all_names: dict) -> str:
    """Return the stated array of a file, otherwise the only one over (y, x)."""
    if variable is not None:
        if variable not in all_names:
            raise InputError(f"variable = {variable!r}: must be one of {', '.join(all_names)}")
        return variable
    if not fields:
        names = ", ".join(all_names) or "nothing"
        raise InputError(f"has no array over (y, x); it contains {names}")
    if len(fields) > 1:
        raise InputError(
            f"has arrays over (y, x): {', '.join(fields)}; {VARIABLE} must name one of them"
        )
    return fields[0]


def _step(name: str, values: np.ndarray) -> float:
    steps = np.abs(np.diff(values.astype(float)))
    if not steps.size or np.ptp(steps) > 1e-4 * steps.mean():
        raise InputError(f"the coordinate {name!r} must be evenly spaced")
    return float(steps.mean())

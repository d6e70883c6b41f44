"""Heights on a regular grid: npy, npz, netCDF, TIFF and GeoTIFF.

Arrays are (y, x), row by row. In npz files and text headers a name may end in its unit, as
everywhere in this project: ``Z_mm``, ``spacing_mm``.
"""

import zipfile
import zlib
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import xarray as xr

from jointclosure.extras import needs
from jointclosure.inputs import InputError
from jointclosure.scans.contents import Contents
from jointclosure.scans.units import split_name

_SPACINGS = ("spacing", "h", "dx")
_METRE, _LINEAR, _VERTICAL = 9001, "ProjLinearUnitsGeoKey", "VerticalUnitsGeoKey"


def read_npy(path: Path, variable: str | None) -> Contents:
    """One array, without units or spacing."""
    _no_variable(variable)
    with _loaded(path) as array:
        if not isinstance(array, np.ndarray):
            raise InputError("is an archive of arrays and no single one; call it .npz")
        return Contents(heights=array)


def read_npz(path: Path, variable: str | None) -> Contents:
    """An array of an archive; its spacing by a number ``spacing``, ``h`` or ``dx``."""
    with _loaded(path) as archive:
        if isinstance(archive, np.ndarray):
            raise InputError("is a single array and no archive of them; call it .npy")
        arrays = {name: archive[name] for name in archive.files}
    name = _chosen(variable, [key for key, value in arrays.items() if value.ndim == 2], arrays)
    height_units = split_name(name)[1]
    for key, value in arrays.items():
        own, units = split_name(key)
        if own in _SPACINGS and value.ndim == 0:
            if value.dtype.kind not in "fiu":
                raise InputError(f"{key} = {value.item()!r}: must be a number")
            step = float(value)
            return Contents(arrays[name], (step, step), None, height_units, units)
    return Contents(arrays[name], None, None, height_units)


def read_netcdf_grid(path: Path, variable: str | None) -> Contents:
    """A variable over (y, x), with the units of its attribute; spacing by its coordinates."""
    try:
        # a file of others: it does not bear the seal of ours
        with xr.open_dataset(path, engine="netcdf4", cache=False) as dataset:
            fields = [str(name) for name, field in dataset.data_vars.items() if field.ndim == 2]
            name = _chosen(variable, fields, {str(key): None for key in dataset.variables})
            field = dataset[name].load()
    except (OSError, ValueError) as error:
        if isinstance(error, InputError):
            raise
        raise InputError(f"cannot be read as netCDF ({error})") from None
    if field.ndim != 2:
        raise InputError(f"variable {name!r} has dimensions {field.dims}: must be over (y, x)")
    coordinates = [field[dimension] for dimension in field.dims if dimension in field.coords]
    spacing = length_units = origin = None
    if len(coordinates) == 2:
        along_y, along_x = (_step(str(c.name), c.values) for c in coordinates)
        spacing = along_y, along_x
        written = {c.attrs.get("units") for c in coordinates}
        if len(written) > 1:
            raise InputError(f"the coordinates are in different units: {written}")
        length_units = written.pop()
        if all(c.values[-1] > c.values[0] for c in coordinates):
            origin = (float(coordinates[0].values[0]), float(coordinates[1].values[0]))
    return Contents(field.values, spacing, None, field.attrs.get("units"), length_units, origin)


def read_tiff(path: Path, variable: str | None) -> Contents:
    """The first page of a TIFF; of a GeoTIFF its pixel size, its units and what is no data."""
    _no_variable(variable)
    with needs("walls", "TIFF"):
        import tifffile
    try:
        with tifffile.TiffFile(path) as file:
            page = file.pages.first
            heights, geo = page.asarray(), page.geotiff_tags or {}
            nothing = page.tags.valueof("GDAL_NODATA")
    except Exception as error:  # of a damaged file the library raises what its bytes lead to
        raise InputError(f"cannot be read as TIFF ({error})") from None
    if heights.ndim != 2 or heights.dtype.kind not in "fiu":
        raise InputError(f"a picture {heights.shape} of {heights.dtype}: must be heights (y, x)")
    heights = heights.astype(float)
    if (value := _no_data(nothing)) is not None:
        heights[heights == value] = np.nan
    spacing = origin = None
    if "ModelPixelScale" in geo:
        across, down = (float(value) for value in geo["ModelPixelScale"][:2])
        spacing = (down, across)
        origin = _first_pixel(geo.get("ModelTiepoint"), spacing)
    units = {
        key: "m" if int(geo[key]) == _METRE else f"EPSG unit {int(geo[key])}"
        for key in (_LINEAR, _VERTICAL)
        if key in geo
    }
    return Contents(heights, spacing, None, units.get(_VERTICAL), units.get(_LINEAR), origin)


def _first_pixel(tie, spacing: tuple[float, float]) -> tuple[float, float] | None:
    """(y, x) of the first pixel from a GeoTIFF's tie point, None where there is not just one.

    y counts downwards, as the rows do: two scans of one frame stay in one.
    """
    if tie is None or len(tie) != 6:
        return None
    column, row, _, x, y, _ = (float(value) for value in tie)
    return -y - row * spacing[0], x - column * spacing[1]


def _no_data(written) -> float | None:
    """The value of pixels without a height, None where the file declares none."""
    word = str("" if written is None else written).strip("\0 ")
    if word.lower() in ("", "none", "null"):
        return None
    try:
        return float(word)
    except ValueError:
        raise InputError(f"GDAL_NODATA = {word!r}: must be a number or none") from None


@contextmanager
def _loaded(path: Path) -> Iterator:
    """What numpy reads of a file, pickles refused; closed again, also where it is damaged."""
    try:
        with path.open("rb") as file:
            yield np.load(file, allow_pickle=False)
    except InputError:
        raise
    except (ValueError, OSError, EOFError, zipfile.BadZipFile, zlib.error) as error:
        raise InputError(f"cannot be read as an array of numbers ({error})") from None


def _chosen(variable: str | None, fields: list[str], all_names: dict) -> str:
    if variable is not None:
        if variable not in all_names:
            raise InputError(f"variable = {variable!r}: must be one of {', '.join(all_names)}")
        return variable
    if len(fields) != 1:
        listed = ", ".join(fields) or "none"
        raise InputError(f"arrays over (y, x): {listed}; choose one by its name (variable)")
    return fields[0]


def _no_variable(variable: str | None) -> None:
    if variable is not None:
        raise InputError(f"variable = {variable!r}: the format has one array without a name")


def _step(name: str, values: np.ndarray) -> float:
    steps = np.abs(np.diff(values.astype(float)))
    if not steps.size or np.ptp(steps) > 1e-4 * steps.mean():
        raise InputError(f"the coordinate {name!r} is not evenly spaced")
    return float(steps.mean())

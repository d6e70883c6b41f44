"""Files of scanned grids: arrays (npy, npz, netCDF, MATLAB), rasters, and files of scanners.

Other arrays and attributes of a file state places, spacing and units of the heights.
"""

import math
import re
import warnings
import zipfile
from collections.abc import Callable, Iterable, Mapping
from functools import partial
from pathlib import Path
from typing import IO, NamedTuple

import numpy as np
import scipy

from jointclosure.inputs import InputError, check_one_of, naming
from jointclosure.inputs.extras import needs
from jointclosure.storage.hdf5 import netCDF4
from jointclosure.walls.scans.contents import (
    VARIABLE,
    Contents,
    Statement,
    agreed_spacing,
    check_array,
    listing,
    reading_as,
    real,
    same_units,
    split_name,
    unit_in,
    unit_ratio,
)
from jointclosure.walls.scans.headers import read_header
from jointclosure.walls.scans.points import contents_of
from jointclosure.walls.scans.text import read_text_scan

_NUMBERS = {"spacing": (1.0, 1.0), "h": (1.0, 1.0), "dy": (1.0, math.nan), "dx": (math.nan, 1.0)}
"""Names of numbers that state the spacing, with 1 for the axes (y, x) to which they apply."""
_AXES = {
    "y": ("y", "lat", "latitude", "northing", "row", "rows", "projection_y_coordinate"),
    "x": ("x", "lon", "longitude", "easting", "column", "columns", "projection_x_coordinate"),
}
"""Names of dimensions, and standard names of coordinates, that identify an axis."""
_LONGEST_TEXT = 400  # largest size [bytes] of a text in a file that is read as a statement
_UNITS = ("units", "unit")  # attributes of a netCDF variable
_OF_LIBRARIES = (
    *_UNITS, "scale_factor", "add_offset", "_fillvalue", "missing_value", "long_name",
    "standard_name", "axis", "coordinates", "history", "title", "comment", "source", "conventions",
    "institution", "references", "grid_mapping",
)  # fmt: skip
"""Attributes of netCDF files that are not read as statements, as libraries apply them, or they are
free words."""
_NEEDED = ("ncols", "nrows")  # words that the header of an ESRI grid must have
_PLACES = ("xllcorner", "yllcorner", "xllcenter", "yllcenter")  # words that state its place
_KNOWN = (*_NEEDED, "cellsize", "dx", "dy", *_PLACES, "nodata_value")  # words of an ESRI header
INSTRUMENTS = re.compile(
    "Wyko ASCII|File Format *= *ASCII|Bit2nm|NT-MDT|height conversion factor"
    "|^[ \t]*[ab](?:ISO|BCR|NIST)-|^# *(?:Kan[aá]l|Canale?|Канал|チャネル|채널) *[:：]".encode(),
    re.IGNORECASE | re.MULTILINE,
)
"""Words by which text files of instruments are recognised, which SurfaceTopography reads."""
_PLAIN = ("asc", "xyz", "mat", "matrix")  # formats of SurfaceTopography for which it takes any text
SURFER = {b"DSAA": "GSAG", b"DSBB": "GSBG", b"DSRB": "GS7BG"}
"""Drivers of GDAL of Surfer grids (text, and binary of versions 6 and 7) by their first bytes."""


class Array(NamedTuple):
    """Array of a file that is not read yet: shape, type, units (None: not stated), and reader."""

    shape: tuple[int, ...]
    dtype: np.dtype
    units: str | None
    load: Callable[[], np.ndarray]

    @property
    def transposed(self) -> "Array":
        """The array with its axes exchanged; its values are read when ``load`` is called."""
        return self._replace(shape=self.shape[::-1], load=lambda: self.load().T)


def grid_of(
    arrays: Mapping[str, Array],
    variable: str | None,
    axes: Mapping[str, str] | None = None,
    lines: Iterable[str] = (),
) -> Contents:
    """Return the contents of a file of arrays: its heights, placed by its other arrays.

    Arrays named x and y are places; they also turn the heights so that y increases with rows and x
    with columns. Single numbers such as "dx" state the spacing. ``variable`` is the name of the
    array of heights (see `chosen`), ``axes`` has the axis "x" or "y" of arrays with other names,
    and ``lines`` are further statements as in a header. If places are unevenly spaced, the contents
    are points. Raise `InputError` if an array does not fit the others.
    """
    texts = {key: array for key, array in arrays.items() if array.dtype.kind == "U"}
    arrays = {key: array for key, array in arrays.items() if key not in texts}
    name = chosen(variable, arrays)
    heights = _loaded(name, arrays[name])
    units = arrays[name].units
    if heights.ndim != 2:
        raise InputError(f"{name} has shape {heights.shape}: must be heights (y, x)")
    beside = {key: array for key, array in arrays.items() if key != name}
    kinds = {key: (axes or {}).get(key, split_name(key)[0].lower()) for key in beside}
    size = {key: math.prod(array.shape) for key, array in beside.items()}
    placing = [key for key in beside if size[key] > 1]
    places = [{key: beside[key] for key in placing if kinds[key] == axis} for axis in "yx"]
    contents, statements = _place_heights(name, heights, places)
    numbers = [key for key in beside if kinds[key] in _NUMBERS and size[key] <= 2]
    others = [key for key in beside if size[key] == 1 and key not in (*numbers, *(axes or {}))]
    header = read_header(
        [*lines, *_header_lines(texts), *_header_lines({k: beside[k] for k in others})]
    )
    units = same_units(name, units, header.height_units)
    if contents.points is not None:
        unused = tuple(f"{key} was not used: the points are on no grid" for key in numbers)
        along = same_units(name, contents.length_units, header.length_units)
        stated = tuple(part.names for part in (*header.steps, *header.sizes))
        return contents._replace(
            height_units=units,
            length_units=along,
            remarks=contents.remarks + unused,
            unread=header.unread + stated,
        )
    for key in numbers:
        step = np.unique(_loaded(key, beside[key]))
        if len(step) > 1 or not 0.0 < step[0] < math.inf:
            raise InputError(f"{key} = {listing(step)}: must be one number, positive and finite")
        statements.append(Statement(key, step * _NUMBERS[kinds[key]], beside[key].units))
    spacing, length_units = agreed_spacing(
        statements + header.statements(np.shape(np.asarray(contents.heights)))
    )
    length_units = same_units(name, length_units, header.length_units)
    if not any(places):
        spacing = np.where(np.isnan(spacing), spacing[::-1], spacing)  # only dx, or only dy
    dy, dx = spacing.tolist()
    return contents._replace(
        spacing=(dy, dx), height_units=units, length_units=length_units, unread=header.unread
    )


def _header_lines(arrays: Mapping[str, Array]) -> list[str]:
    """Return arrays of one text or number as header lines "name: value"; others are left out."""
    lines = []
    for key, array in arrays.items():
        if math.prod(array.shape) == 1 and array.dtype.itemsize <= _LONGEST_TEXT:
            lines.append(f"{key}: {np.asarray(array.load()).item()}")
    return lines


def _place_heights(
    name: str, heights: np.ndarray, places: list[dict[str, Array]]
) -> tuple[Contents, list[Statement]]:
    """Return heights (y, x) as a grid or as points, and what places state of the spacing.

    ``places`` are the arrays of places along y, and along x, by name. Heights (x, y) are turned if
    only so they fit the places. Raise `InputError` if places fit neither, or if they are uneven
    along one axis and missing along the other.
    """
    named = places[0] | places[1]
    if not named:
        return Contents(heights), []
    if not _places_fit(places, heights.shape):
        if not _places_fit(places, heights.T.shape):
            shapes = ", ".join(f"{key} ({listing(array.shape)})" for key, array in named.items())
            raise InputError(f"{shapes}: must be places of {name} ({listing(heights.shape)})")
        heights = heights.T
    names = " and ".join(named)
    units = next((a.units for a in named.values() if a.units), None)
    (y, dy), (x, dx) = (
        _places_along_axis(number, along, units) for number, along in enumerate(places)
    )
    if dy is None or dx is None:
        if y is None or x is None:
            raise InputError(f"{names}: must be evenly spaced, or places along both axes")
        columns = np.broadcast_arrays(x, y, heights)
        points = np.stack([column.ravel() for column in columns], axis=1)
        contents = contents_of(points, (units, units, None))
        return contents, [Statement(names, np.array(contents.spacing), units)]
    heights = heights[:: -1 if dy < 0.0 else 1, :: -1 if dx < 0.0 else 1]
    first_y, first_x = (math.nan if along is None else float(along.min()) for along in (y, x))
    contents = Contents(heights, origin=(first_y, first_x))
    return contents, [Statement(names, np.abs([dy, dx]), units)]


def _places_fit(places: list[dict[str, Array]], shape: tuple[int, ...]) -> bool:
    """Return whether places along y and x are vectors or matrices that fit heights of a shape."""
    return all(
        tuple(n for n in array.shape if n > 1) in (shape, (shape[number],))
        for number, along in enumerate(places)
        for array in along.values()
    )


def _places_along_axis(
    number: int, arrays: dict[str, Array], units: str | None
) -> tuple[np.ndarray | None, float | None]:
    """Return the places along an axis (0: y, 1: x) that arrays state, and their step.

    Places are in ``units``. They are one row or column if all rows or columns of a matrix are
    equal. The step is None if places are uneven or differ between rows or columns. Without arrays
    places are None, and the step is NaN. Raise `InputError` if arrays state different places.
    """
    values: np.ndarray | None = None
    ranges = []
    for key, array in arrays.items():
        read = _loaded(key, array).squeeze()
        ranges.append(f"{key} {np.nanmin(read):g} to {np.nanmax(read):g}")
        read = read * unit_ratio(array.units, units)
        if read.ndim == 1:
            read = np.expand_dims(read, 1 - number)
        elif (read == (line := read.take([0], 1 - number))).all():
            read = line
        if values is not None and not np.allclose(
            read, values, rtol=0.0, atol=0.01 * np.ptp(values) / max(read.shape), equal_nan=True
        ):
            raise InputError(f"{', '.join(ranges)}: must be the same places")
        values = read
    if values is None:
        return None, math.nan
    if values.shape[1 - number] > 1:
        return values, None
    steps = np.diff(values.ravel())
    mean = float(steps.mean())
    return values, mean if np.ptp(steps) <= 1e-4 * abs(mean) and mean != 0.0 else None


def _loaded(name: str, array: Array) -> np.ndarray:
    """Read an array of real numbers, NaN where masked or not finite; check its type and size."""
    with naming(name):
        check_array(array.shape, array.dtype)
        return real(array.load())


def chosen(variable: str | None, arrays: Mapping[str, Array]) -> str:
    """Return the name of the array of heights: ``variable``, else the only array over (y, x).

    Arrays named x or y are places, not heights. Raise `InputError` if there is no such array, or if
    several arrays could be the heights.
    """
    if variable is not None:
        check_one_of("variable", variable, tuple(arrays))
        return variable
    fields = [name for name, of in arrays.items() if len(of.shape) == 2 and min(of.shape) > 2]
    fields = [name for name in fields if split_name(name)[0].lower() not in ("x", "y")]
    if not fields:
        raise InputError(f"has no array over (y, x); it contains {', '.join(arrays) or 'nothing'}")
    if len(fields) > 1:
        listed = ", ".join(fields)
        raise InputError(f"has arrays over (y, x): {listed}; {VARIABLE} must name one of them")
    return fields[0]


def read_npy(path: Path) -> Contents:
    """Read the array of a .npy file, which states neither units nor spacing."""
    return Contents(_read_array(lambda: path.open("rb")))


def read_npz(path: Path, variable: str | None) -> Contents:
    """Read the heights of an npz archive; other arrays state places and units, see `grid_of`."""
    with zipfile.ZipFile(path) as archive:
        arrays = {}
        for member in archive.namelist():
            name = member.removesuffix(".npy")
            opened = partial(archive.open, member)
            with opened() as content:
                head = _array_header(content)
            arrays[name] = Array(*head, split_name(name)[1], partial(_read_array, opened))
        return grid_of(arrays, variable)


def _array_header(file: IO[bytes]) -> tuple[tuple[int, ...], np.dtype]:
    """Return the shape and type that the header of a .npy file declares."""
    version = np.lib.format.read_magic(file)
    read = np.lib.format.read_array_header_1_0
    shape, _, kind = (read if version == (1, 0) else np.lib.format.read_array_header_2_0)(file)
    return shape, kind


def _read_array(opened: Callable[[], IO[bytes]]) -> np.ndarray:
    """Read an array of a .npy file; `InputError` if it is too large, and pickles are refused."""
    with opened() as file:
        shape, kind = _array_header(file)
        if kind.kind != "U":  # a text beside heights, which is read if it is short
            check_array(shape, kind)
        file.seek(0)
        return np.lib.format.read_array(file, allow_pickle=False)


def read_netcdf_grid(path: Path, variable: str | None) -> Contents:
    """Read the heights of a netCDF file; names of dimensions tell which axes are y and x.

    Masked and infinite values are NaN. Other variables state places and units, see `grid_of`.
    """
    with netCDF4.Dataset(path) as dataset:
        variables = dataset.variables
        arrays = {}
        for key, read in variables.items():
            kind = np.dtype(read.dtype)
            load = partial(read.__getitem__, ...)
            arrays[key] = Array(read.shape, kind, _stated_units(key, read), load)
        name = chosen(variable, arrays)
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
        kept = [key for key in arrays if set(variables[key].dimensions) <= set(dimensions)]
        used = {key: arrays[key].transposed if turned else arrays[key] for key in kept}
        lines = _attribute_lines(dataset) + _attribute_lines(variables[name])
        named = dict(zip(dimensions, "xy" if turned else "yx", strict=True))
        contents = grid_of(used, name, named, lines)
    return contents._replace(remarks=remarks + contents.remarks)


def _stated_units(key: str, variable: netCDF4.Variable) -> str | None:
    """Return the units that a variable's attributes, its name or its long name state, or None.

    A unit in an attribute that is no known unit of length is returned as it is.
    """
    attributes = {name.lower(): variable.getncattr(name) for name in variable.ncattrs()}
    stated = [str(attributes[name]).strip() for name in _UNITS if name in attributes]
    named = [split_name(text)[1] for text in (key, str(attributes.get("long_name", "")))]
    known = [unit for unit in (*map(unit_in, stated), *named) if unit]
    other = next((unit for unit in stated if unit and unit_in(unit) is None), None)
    return other or same_units(key, *known)


def _attribute_lines(of: netCDF4.Dataset | netCDF4.Variable) -> list[str]:
    """Return attributes of a netCDF file or variable as header lines "name: value".

    Those are left out that cannot be statements (`_OF_LIBRARIES`), or that have several values.
    """
    left = _OF_LIBRARIES if isinstance(of, netCDF4.Variable) else _OF_LIBRARIES[len(_UNITS) :]
    used = [name for name in of.ncattrs() if name.lower() not in left]
    values = {name: np.asarray(of.getncattr(name)) for name in used if "valid" not in name}
    return [f"{name}: {value.item()}" for name, value in values.items() if value.size == 1]


def _axis_of(dimension: str, variables: dict[str, netCDF4.Variable]) -> str | None:
    """Return the axis ("x", "y") of a netCDF dimension, by its coordinate's attributes or name.

    None if neither identifies an axis.
    """
    about = variables.get(dimension)
    words = [getattr(about, key, None) for key in ("axis", "standard_name")]
    words = [str(word).lower() for word in (*words, split_name(dimension)[0]) if word]
    return next((axis for word in words for axis in _AXES if word in _AXES[axis]), None)


def read_matlab(path: Path, variable: str | None) -> Contents:
    """Read the heights of a MATLAB file of version 7.2 or earlier.

    Only the arrays of numbers and texts that are needed are loaded; other arrays state places and
    units, see `grid_of`.
    """

    def load(name: str) -> np.ndarray:
        return scipy.io.loadmat(path, variable_names=[name])[name]

    declared = scipy.io.whosmat(path)
    arrays = {}
    for name, shape, kind in declared:
        if "int" in kind or kind in ("double", "single", "logical"):
            number = np.dtype("bool" if kind == "logical" else kind)
            arrays[name] = Array(shape, number, split_name(name)[1], partial(load, name))
        elif kind == "char":
            arrays[name] = Array((1,), np.dtype("U1"), None, partial(load, name))
    try:
        return grid_of(arrays, variable)
    except InputError as error:
        within = ", ".join(name for name, _, kind in declared if kind in ("struct", "cell"))
        hint = f"; save arrays of {within} as variables of their own" if within else ""
        raise InputError(f"{error}{hint}") from None


def read_esri(path: Path) -> Contents:
    """Read an ESRI ASCII grid, whose rows begin with the largest y.

    GDAL is not used for it, as it reads words among the heights as zeros. Raise `InputError` if the
    header is incomplete, or the number of heights differs from it.
    """
    lines = [line.split() for line in path.read_text(encoding="latin-1").lower().splitlines()]
    rows = [line for line in lines if line and line[0] not in _KNOWN]
    head: dict[str, float] = {}
    for key, value in (line for line in lines if line and line[0] in _KNOWN):
        if key in head:
            raise InputError(f"{key}: must be only once in the header")
        head[key] = float(value)
        if key in _NEEDED and not head[key].is_integer():
            raise InputError(f"{key} = {value}: must be a whole number")
    if missing := [key for key in _NEEDED if key not in head]:
        raise InputError(f"its header lacks {', '.join(missing)}")
    steps = _NUMBERS | {"cellsize": (1.0, 1.0)}
    stated = [Statement(key, head[key] * np.array(steps[key])) for key in head if key in steps]
    dy, dx = agreed_spacing(stated)[0].tolist()
    if math.isnan(dy + dx):
        raise InputError("its header lacks cellsize, or both dx and dy")
    shape = int(head["nrows"]), int(head["ncols"])
    check_array(shape)
    values = [value for row in rows for value in row]
    if len(values) != math.prod(shape):
        declared = f"declares {shape[0]} rows of {shape[1]} heights, {math.prod(shape)}"
        raise InputError(f"{declared}, and contains {len(values)}: is the file incomplete?")
    counts = {len(row) for row in rows}
    if shape[1] in counts and len(counts) > 1:  # otherwise rows are wrapped
        raise InputError(f"has rows of {min(counts)} to {max(counts)} heights: must be {shape[1]}")
    heights = np.array(values, dtype=float).reshape(shape)[::-1].copy()
    heights[heights == head.get("nodata_value", -9999.0)] = np.nan
    # the middle of the first cell, if the file places it
    y, x = (
        head.get(f"{axis}llcenter", head.get(f"{axis}llcorner", np.nan) + 0.5 * step)
        for axis, step in (("y", dy), ("x", dx))
    )
    return Contents(heights, (dy, dx), origin=(y, x))


def read_raster(path: Path, driver: str) -> Contents:
    """Read a raster of one band by a driver of GDAL; heights lie in the middles of its cells.

    Raise `InputError` if it has several bands, or is turned or mirrored.
    """
    with needs("walls", "a TIFF or Surfer grid"):
        import rasterio
        from rasterio.errors import NotGeoreferencedWarning, RasterioIOError
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", NotGeoreferencedWarning)
        with (
            # files beside this one, such as .aux.xml and .tfw, are not read
            rasterio.Env(GDAL_PAM_ENABLED="NO", GDAL_DISABLE_READDIR_ON_OPEN="EMPTY_DIR"),
            rasterio.open(path, driver=driver) as raster,
        ):
            if raster.count != 1:
                raise InputError(f"has an image of {raster.count} bands: must be one, of heights")
            check_array(raster.shape, np.dtype(raster.dtypes[0]))
            try:
                heights = raster.scales[0] * real(raster.read(1, masked=True)) + raster.offsets[0]
            except RasterioIOError as error:  # its message leaves out the cause
                raise error.__cause__ or error from None
            transform = raster.transform
            crs = raster.crs
            units = raster.units[0]
            tags = raster.tags()
    if transform.is_identity:  # not stated
        (dy, dx), across, unread = _resolution_of(tags)
        return Contents(heights, (dy, dx), height_units=units, length_units=across, unread=unread)
    dx, along_x, left, along_y, dy, top = transform[:6]
    if along_x or along_y or dx <= 0.0:
        raise InputError("is turned or mirrored: columns must be along x, and rows along y")
    if dy < 0.0:
        top = top + dy * len(heights)
        heights = heights[::-1]
        dy = -dy
    across = crs.units_factor[0] if crs and crs.units_factor[0] != "unknown" else None
    return Contents(heights, (dy, dx), None, units, across, (top + 0.5 * dy, left + 0.5 * dx))


def _resolution_of(
    tags: Mapping[str, str],
) -> tuple[tuple[float, float], str | None, tuple[str, ...]]:
    """Return the spacing (dy, dx), its units, and unused statements, of the ``tags`` of a TIFF.

    Spacing and units are read only if ImageJ wrote the file. Otherwise they are NaN and None, and
    a resolution in pixels per inch or cm is an unused statement, as it is often meaningless.
    """
    pixels = [float(tags.get(f"TIFFTAG_{axis}RESOLUTION", 0.0)) for axis in "YX"]
    about = tags.get("TIFFTAG_IMAGEDESCRIPTION", "")
    unit = re.search(r"^unit=(.+)$", about, re.MULTILINE)
    if about.startswith("ImageJ=") and unit and min(pixels) > 0.0:
        word = unit[1].strip().replace("\\u00B5", "µ")
        return (1.0 / pixels[0], 1.0 / pixels[1]), word, ()
    kind = {"2": "inch", "3": "cm"}.get(tags.get("TIFFTAG_RESOLUTIONUNIT", "")[:1])
    unread: tuple[str, ...] = ()
    if kind and min(pixels) > 0.0:
        unread = (f"a resolution of {listing(pixels[::-1])} pixels per {kind}",)
    return (math.nan, math.nan), None, unread


def read_text_or_scanner(path: Path, variable: str | None) -> Contents:
    """Read a file as text of points or a matrix; if that fails, as the file of a scanner.

    Raise the `InputError` of reading it as text if both fail.
    """
    try:
        return read_text_scan(path, variable)
    except InputError as error:
        try:
            with reading_as("a scanner's file"):
                return read_scanner(path, variable, refused=_PLAIN)
        except InputError:
            raise error from None


def read_scanner(path: Path, variable: str | None, refused: tuple[str, ...] = ()) -> Contents:
    """Read one channel of a scanner's file with SurfaceTopography.

    The channel is that named ``variable``, otherwise the default of the file. Raise `InputError` if
    the format is not known or in ``refused``, or if the channel is no surface.
    """
    with needs("walls", f"{path.suffix or 'a file without suffix'}: a scanner's format"):
        from SurfaceTopography.Exceptions import CannotDetectFileFormat
        from SurfaceTopography.IO import open_topography
    try:
        opened = open_topography(str(path))
    except CannotDetectFileFormat:  # its message has the errors of all readers
        problem = "is of no form that is read here; text must be .txt, .csv or .xyz"
        raise InputError(problem) from None
    with opened as reader:
        if reader.format() in refused:
            raise InputError("is no file of a scanner")
        channel = reader.default_channel
        index = None
        if variable is not None:
            names = [channel.name for channel in reader.channels]
            check_one_of("variable", variable, tuple(names))
            index = names.index(variable)
            channel = reader.channels[index]
        check_array(tuple(channel.nb_grid_pts))
        sized = channel.physical_sizes is not None
        given = {} if sized else {"physical_sizes": tuple(channel.nb_grid_pts)}
        surface = reader.topography(channel_index=index, **given)
        if surface.dim != 2:
            raise InputError("contains a profile, must be a surface")
        # its arrays are (x, y)
        heights = surface.heights().T
        dx, dy = surface.pixel_size
        units = surface.unit
    spacing = (float(dy), float(dx)) if sized else (math.nan, math.nan)
    return Contents(heights, spacing, None, units, units)

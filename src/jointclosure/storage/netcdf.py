"""NetCDF files, written completely or not at all; a digest at their end reveals changes."""

import contextlib
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any

import xarray as xr

from jointclosure.storage.files import atomically, check_seal, seal
from jointclosure.storage.hdf5 import netCDF4

_CHUNK_CACHE = 1_000_000
"""Bytes of a variable that netCDF keeps in memory while blocks are written, instead of 64 MB."""
_LOCKS = (
    "if there is room on the disk, its file system refuses the locks of HDF5: set "
    "HDF5_USE_FILE_LOCKING=FALSE before Python starts"
)
Place = dict[str, slice | int]  # position of a region in a dataset, by dimension


def write_netcdf(
    dataset: xr.Dataset,
    path: str | Path,
    regions: Iterable[tuple[Place, xr.Dataset]] = (),
    dimension: str | None = None,
    chunks: Mapping[str, int] = {},
) -> None:
    """Write a dataset to a netCDF file, compressed and sealed, completely or not at all.

    A large dataset can be written in parts along a ``dimension``. The ``dataset`` has then one
    entry along it, which fixes names and types, and ``regions`` (position, values) are written one
    by one. A region lacks the dimensions in which its position is a number. ``chunks`` are the
    lengths, by dimension, of blocks that are compressed together. Raise `OSError` if the file
    cannot be written.
    """
    dataset = dataset.drop_encoding()
    encoding = dict[Any, dict[str, Any]]()
    sizes: dict[Any, int] = dict(dataset.sizes) | dict(chunks)
    for name, variable in dataset.variables.items():
        if variable.dtype.kind in "fiu" and variable.ndim > 0:
            encoding[name] = {"zlib": True, "complevel": 1}
        if dimension in variable.dims:
            encoding.setdefault(name, {})["chunksizes"] = [sizes[size] for size in variable.dims]
    form: dict[str, Any] = {"engine": "netcdf4", "encoding": encoding}

    def write(temporary: Path) -> None:
        """Write and seal the temporary file; raise `OSError` for all errors of netCDF."""
        try:
            dataset.to_netcdf(temporary, unlimited_dims=[dimension] if dimension else None, **form)
            if dimension:
                with netCDF4.Dataset(temporary, "a") as file:
                    for stored in file.variables.values():
                        stored.set_var_chunk_cache(_CHUNK_CACHE)
                    for place, region in regions:
                        _write_region(file, region, place)
        except RuntimeError as error:  # how netCDF reports errors of writing
            raise OSError(str(error)) from error
        except PermissionError as error:  # not of the folder, in which the file was just made
            raise OSError(f"{error.strerror or error}; {_LOCKS}") from error
        seal(temporary)

    atomically(path, write)


def _write_region(file: netCDF4.Dataset, region: xr.Dataset, place: Place) -> None:
    """Write a region to an open file: its variables that have a dimension of its ``place``."""
    for name, variable in region.variables.items():
        dimensions = file[str(name)].dimensions
        if set(dimensions) & set(place) & set(variable.dims):
            index = tuple(place.get(size, slice(None)) for size in dimensions)
            file[str(name)][index] = variable.values


def read_netcdf(path: str | Path, without: tuple[str, ...] = ()) -> xr.Dataset:
    """Read a dataset that `write_netcdf` wrote into memory, without the variables ``without``.

    Raise `DamagedFileError` if any bit of the file has changed.
    """
    with reading_netcdf(path) as dataset:
        return dataset.drop_vars(without, errors="ignore").load()


@contextlib.contextmanager
def reading_netcdf(path: str | Path) -> Iterator[xr.Dataset]:
    """Open a dataset whose values are read when they are used, and close it at the end.

    The whole file is checked first. Raise `DamagedFileError` if any bit of it has changed.
    """
    check_seal(Path(path))
    with xr.open_dataset(path, engine="netcdf4", cache=False) as dataset:
        yield dataset

"""Reading of a study's netCDF files, which must be undamaged and belong to this study.

The attribute ``key`` of a file is the digest of what it was made from. All jobs read files with
these functions, so that a file that was made from other settings raises an error.
"""

import contextlib
from collections.abc import Iterator
from pathlib import Path

import xarray as xr

from jointclosure.inputs import InputError
from jointclosure.storage.files import MAKE_AGAIN
from jointclosure.storage.netcdf import reading_netcdf


class ForeignFileError(InputError):
    """Error for an undamaged file that does not belong to this study."""


def foreign(path: str | Path) -> ForeignFileError:
    """Return the error for a file that was made from other settings, surfaces or code."""
    return ForeignFileError(
        f"{path}: is not of this study (other settings, surfaces or code): {MAKE_AGAIN}"
    )


@contextlib.contextmanager
def reading_checked(path: str | Path, key: str) -> Iterator[xr.Dataset]:
    """Open a file of this study as a dataset, whose values are read when they are used.

    It is closed when the context ends.

    Raises
    ------
    DamagedFileError
        If the file is not as it was written.
    ForeignFileError
        If its attribute ``key`` differs: it was made with other settings or by other code.
    """
    with reading_netcdf(path) as stored:
        if stored.attrs.get("key") != key:
            raise foreign(path)
        yield stored


def read_checked(path: str | Path, key: str, without: tuple[str, ...] = ()) -> xr.Dataset:
    """Read a file of this study into memory, except the variables ``without``.

    Errors are as for `reading_checked`. Variables that the file lacks are ignored.
    """
    with reading_checked(path, key) as stored:
        return stored.drop_vars(without, errors="ignore").load()

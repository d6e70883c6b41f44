"""Files of a study that are checked where they are read: of this study, and as they were written.

Each has the key of what it was made from in its attributes. It is compared at this door, which all
jobs share, so that a file of other settings put in its place becomes an error and not a table.
"""

import contextlib
from collections.abc import Iterator
from pathlib import Path

import xarray as xr

from jointclosure.inputs import InputError
from jointclosure.storage.files import MAKE_AGAIN
from jointclosure.storage.netcdf import reading_netcdf


class ForeignFileError(InputError):
    """Error for a file that is whole, but not of this study."""


def foreign(path: str | Path) -> ForeignFileError:
    """Return the error for a file of other settings, surfaces or code."""
    return ForeignFileError(
        f"{path}: is not of this study (other settings, surfaces or code): {MAKE_AGAIN}"
    )


@contextlib.contextmanager
def reading_checked(path: str | Path, key: str) -> Iterator[xr.Dataset]:
    """Open a file of this study, whose values are read when they are used.

    Raises
    ------
    DamagedFileError
        If the file is not as it was written.
    ForeignFileError
        If it was made with other settings or by other code; ``key`` is that of its attributes.
    """
    with reading_netcdf(path) as stored:
        if stored.attrs.get("key") != key:
            raise foreign(path)
        yield stored


def read_checked(path: str | Path, key: str, without: tuple[str, ...] = ()) -> xr.Dataset:
    """Read a file of this study without some variables; errors as for `reading_checked`."""
    with reading_checked(path, key) as stored:
        return stored.drop_vars(without, errors="ignore").load()

"""Files of a study, which are read only if they are undamaged and belong to this study.

The attribute ``key`` of a file is the digest of what it was made from. All jobs read files with
these functions, so that a file of other settings in its place raises an error.
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
    """Return the error for a file of other settings, surfaces or code."""
    return ForeignFileError(
        f"{path}: is not of this study (other settings, surfaces or code): {MAKE_AGAIN}"
    )


@contextlib.contextmanager
def reading_checked(path: str | Path, key: str) -> Iterator[xr.Dataset]:
    """Open a file of this study; its values are read when they are used.

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
    """Read a file of this study, except variables ``without``; errors as for `reading_checked`."""
    with reading_checked(path, key) as stored:
        return stored.drop_vars(without, errors="ignore").load()

"""The library of netCDF files, loaded so that it needs no locks.

Some file systems have no locks, and HDF5 then refuses to read and to write. No lock is needed here:
a file is written under a name of its own and renamed. HDF5 reads the variable when it is first
used. A value that the user has set stays.
"""

import os

os.environ.setdefault("HDF5_USE_FILE_LOCKING", "FALSE")

import netCDF4

__all__ = ["netCDF4"]

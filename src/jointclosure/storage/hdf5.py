"""The netCDF4 library, imported so that HDF5 needs no file locks.

Some file systems have no locks, and HDF5 then refuses to read and to write. No lock is needed here:
a file is written under a name of its own and renamed. Therefore the environment variable
``HDF5_USE_FILE_LOCKING`` is set to FALSE for this process before the import, because HDF5 reads it
when it is first used. A value that the user has set stays.
"""

import os

os.environ.setdefault("HDF5_USE_FILE_LOCKING", "FALSE")

import netCDF4

__all__ = ["netCDF4"]

"""Folder of machine code and digests, beside the package or in the user's cache."""

import contextlib
import os
import stat
import tempfile
from functools import lru_cache
from pathlib import Path

PACKAGE = Path(__file__).parents[1]
"""Folder of the package jointclosure."""


def cache_root() -> Path:
    """Return the folder for compiled kernels and for digests of code; it may not exist yet.

    It is the one that the variable JOINTCLOSURE_CACHE names, or is beside the package if that can
    be written, or in the user's cache folder, or else a `temporary_cache`.
    """
    if chosen := os.environ.get("JOINTCLOSURE_CACHE"):
        return Path(chosen)
    beside = PACKAGE / "__pycache__"
    if os.access(beside if beside.exists() else PACKAGE, os.W_OK):
        return beside
    if chosen := os.environ.get("XDG_CACHE_HOME"):
        return Path(chosen) / "jointclosure"
    return Path.home() / ".cache" / "jointclosure" if has_home() else temporary_cache()


def has_home() -> bool:
    """Return whether the user has a home folder, because HOME is set or the system lists one.

    In many containers there is none.
    """
    try:
        return bool(Path.home())
    except RuntimeError:
        return False


@lru_cache(maxsize=None)
def temporary_cache() -> Path:
    """Return a folder for temporary files that no other user can write.

    It is the one of this user if it can be trusted, which is made if need be, or else a new one.
    """
    user = os.getuid() if hasattr(os, "getuid") else 0
    folder = Path(tempfile.gettempdir()) / f"jointclosure-{user}"
    with contextlib.suppress(OSError):
        folder.mkdir(mode=0o700, exist_ok=True)
        about = folder.lstat()  # machine code is loaded from it: a link may lead elsewhere
        if stat.S_ISDIR(about.st_mode) and about.st_uid == user and not about.st_mode & 0o022:
            return folder
    return Path(tempfile.mkdtemp(prefix="jointclosure-"))

"""Folder of machine code and digests, beside the package or in the user's cache."""

import contextlib
import os
import stat
import tempfile
from functools import lru_cache
from pathlib import Path

PACKAGE = Path(__file__).parents[1]
"""Folder of jointclosure."""


def cache_root() -> Path:
    """Return the folder of compiled kernels and of digests."""
    if chosen := os.environ.get("JOINTCLOSURE_CACHE"):
        return Path(chosen)
    beside = PACKAGE / "__pycache__"
    if os.access(beside if beside.exists() else PACKAGE, os.W_OK):
        return beside
    if chosen := os.environ.get("XDG_CACHE_HOME"):
        return Path(chosen) / "jointclosure"
    return Path.home() / ".cache" / "jointclosure" if has_home() else temporary_cache()


def has_home() -> bool:
    """Return whether the user has a home folder: HOME is set, or the list of users has one.

    Many containers have neither.
    """
    try:
        return bool(Path.home())
    except RuntimeError:
        return False


@lru_cache(maxsize=None)
def temporary_cache() -> Path:
    """Return a folder for temporary files that no other user can write; a new one if need be."""
    user = os.getuid() if hasattr(os, "getuid") else 0
    folder = Path(tempfile.gettempdir()) / f"jointclosure-{user}"
    with contextlib.suppress(OSError):
        folder.mkdir(mode=0o700, exist_ok=True)
        about = folder.lstat()  # machine code is loaded from it: a link may lead elsewhere
        if stat.S_ISDIR(about.st_mode) and about.st_uid == user and not about.st_mode & 0o022:
            return folder
    return Path(tempfile.mkdtemp(prefix="jointclosure-"))

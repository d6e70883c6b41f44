"""How kernels are compiled, and where their machine code is kept.

Numba's own check of its disk cache looks at the file of a function only: an
edit in another module that the function calls goes unnoticed and yields
silently wrong numbers. The cache folder is therefore named by a digest of
all sources of the package. It lies beside the sources, or in the user's
cache folder where that is read-only; ``JOINTCLOSURE_CACHE`` overrides both.
The first compilation of a process is announced by the logger ``jointclosure``.
"""

import hashlib
import logging
import os
from collections.abc import Callable
from pathlib import Path

import numba
import numpy as np
from numba.core import event

PACKAGE = Path(__file__).parent


def source_digest(*parts: str) -> str:
    """Digest of the package's sources: what a result depends on.

    Parameters
    ----------
    *parts
        Names of modules or sub-packages ("mechanics", "protocol"). All of
        the package when none is given.

    Returns
    -------
    str
        16 hexadecimal digits over names and contents; time stamps do not
        count.

    Raises
    ------
    FileNotFoundError
        A part that does not exist.
    """
    files: list[Path] = []
    for part in parts or (".",):
        folder, module = PACKAGE / part, PACKAGE / f"{part}.py"
        if not folder.is_dir() and not module.is_file():
            raise FileNotFoundError(f"jointclosure has no part {part!r}")
        files += folder.rglob("*.py") if folder.is_dir() else [module]
    digest = hashlib.sha256()
    for file in sorted(set(files)):
        digest.update(file.relative_to(PACKAGE).as_posix().encode() + b"\0")
        digest.update(file.read_bytes() + b"\0")
    return digest.hexdigest()[:16]


def cache_folder() -> Path:
    """Folder of the compiled kernels for the sources as they are now."""
    name = f"numba-{source_digest()}"
    if chosen := os.environ.get("JOINTCLOSURE_CACHE"):
        return Path(chosen) / name
    beside = PACKAGE / "__pycache__"
    if os.access(beside if beside.exists() else PACKAGE, os.W_OK):
        return beside / name
    home = os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
    return Path(home) / "jointclosure" / name


numba.config.CACHE_DIR = str(cache_folder())


class _Announcement(event.Listener):
    """Says once that kernels are being compiled, as nothing else happens meanwhile; counts them."""

    def __init__(self):
        self.count = 0

    def on_start(self, event):
        self.count += 1
        if self.count == 1:
            logging.getLogger("jointclosure").warning(
                "jointclosure: compiling kernels, once for this version (up to a minute)"
            )

    def on_end(self, event):
        pass


_announcement = _Announcement()
event.register("numba:compile", _announcement)


def compiles() -> int:
    """How often this process has compiled, rather than found machine code in the cache."""
    return _announcement.count


def kernel(function: Callable) -> Callable:
    """Compile a numerical kernel: cached on disk, serial, IEEE arithmetic.

    Divisions follow numpy (no exception on 0/0), so a kernel guards its own
    singular cases. With ``NUMBA_DISABLE_JIT=1`` the function stays Python, and
    numpy's numbers are then as silent about 0/0 as compiled ones.

    A closure is named after the plain values that it closes over. Its machine
    code bears its name and a number counted from the start of the process, so
    that two closures of one factory, compiled in two processes, could bear the
    same, and fail in a third process that loads both from the cache.
    """
    cells = zip(function.__code__.co_freevars, function.__closure__ or (), strict=True)
    flags = [(name, cell.cell_contents) for name, cell in cells]
    function.__qualname__ += "".join(
        f"_{name}_{value}" for name, value in flags if isinstance(value, bool)
    )
    compiled = numba.njit(function, cache=True, error_model="numpy", nogil=True, forceinline=True)
    if numba.config.DISABLE_JIT:
        return np.errstate(divide="ignore", invalid="ignore", over="ignore")(compiled)
    return compiled

"""How kernels are compiled, and where their machine code is kept.

Numba's own check of its disk cache looks at the file of a function only: an
edit in another module that the function calls goes unnoticed and yields
silently wrong numbers. The cache folder is therefore named by a digest of
the code that kernels are made of. It lies beside the sources, or in the user's
cache folder where that is read-only; ``JOINTCLOSURE_CACHE`` overrides both.
The first compilation of a process is announced by the logger ``jointclosure``.
"""

import contextlib
import logging
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numba
import numpy as np
from numba.core import event

from jointclosure.sources import PACKAGE, code_digest, raw_digest

KERNEL_PARTS = ("mechanics", "solvers", "compilation")
"""Where kernels are; what these import counts too."""


def cache_folder() -> Path:
    """Folder of the compiled kernels for their code as it is now."""
    root = _cache_root()
    # the digest of the code takes longer than all else at the start of a job: it is kept
    known = root / f"kernels-of-{raw_digest()}"
    if known.is_file() and (code := known.read_text(encoding="utf-8")):
        return root / f"numba-{code}"
    code = code_digest(*KERNEL_PARTS)
    with contextlib.suppress(OSError):  # without it the next start takes longer, and no more
        root.mkdir(parents=True, exist_ok=True)
        temporary = known.with_suffix(f".{os.getpid()}")
        temporary.write_text(code, encoding="utf-8")
        temporary.replace(known)
    return root / f"numba-{code}"


def _cache_root() -> Path:
    if chosen := os.environ.get("JOINTCLOSURE_CACHE"):
        return Path(chosen)
    beside = PACKAGE / "__pycache__"
    if os.access(beside if beside.exists() else PACKAGE, os.W_OK):
        return beside
    home = os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
    return Path(home) / "jointclosure"


numba.config.CACHE_DIR = str(cache_folder())  # type: ignore[attr-defined]


class _Announcement(event.Listener):
    """Says once that kernels are being compiled, as nothing else happens meanwhile; counts them."""

    def __init__(self) -> None:
        self.count = 0

    def on_start(self, event: event.Event) -> None:
        self.count += 1
        if self.count == 1:
            logging.getLogger("jointclosure").warning(
                "jointclosure: compiling kernels, once for this version (up to a minute)"
            )

    def on_end(self, event: event.Event) -> None:
        pass


_announcement = _Announcement()
event.register("numba:compile", _announcement)  # type: ignore[no-untyped-call]


def compiles() -> int:
    """How often this process has compiled, rather than found machine code in the cache."""
    return _announcement.count


def kernel(function: Callable[..., Any]) -> Callable[..., Any]:
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
    if numba.config.DISABLE_JIT:  # type: ignore[attr-defined]
        return np.errstate(divide="ignore", invalid="ignore", over="ignore")(compiled)
    return compiled

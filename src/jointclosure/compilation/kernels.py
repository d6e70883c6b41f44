"""Compilation of kernels, and location of their machine code.

Numba's check of its disk cache considers only the file of a function, so that an edit in another
module whose functions it calls gives silently wrong numbers. Therefore the cache folder is named by
a digest of the code of the kernels and of the versions that compile it. Shipped machine code is
loaded where code, versions and processor allow. Numba's settings, which apply to the whole process,
are not changed.
"""

import hashlib
import importlib.metadata
import logging
import platform
import sys
from collections.abc import Callable
from functools import lru_cache
from pathlib import Path
from typing import Any

import numba
import numpy as np
from numba.core import types
from numba.core.caching import (
    CompileResultCacheImpl,
    FunctionCache,
    IndexDataCacheFile,
    _CacheLocator,
)
from numba.core.registry import cpu_target
from numba.core.runtime import rtsys

from jointclosure.compilation.cache_folder import PACKAGE, cache_root
from jointclosure.compilation.code_digests import code_digest

SHIPPED = PACKAGE / "compiled"
"""Machine code in the package, made by ``python -m jointclosure.joint.warmup ship``."""
X86 = platform.machine() in ("x86_64", "AMD64")  # both are names of this kind of processor
PROCESSOR = "x86-64-v3" if X86 else "generic"
"""Processor for which shipped code is made: the code is as fast as code for a newer processor, and
gives the same bits."""
FEATURES = {"+avx2", "+bmi", "+bmi2", "+f16c", "+fma", "+lzcnt", "+movbe"} if X86 else set()
"""Features that a processor needs to run shipped code."""

_NUMBER = "number_of_kernels"
"""File beside machine code with the number of all kernels, written when all were compiled."""

KERNEL_PARTS = ("mechanics", "solvers", "compilation")
"""Packages that contain kernels; modules that they import are included too."""


@lru_cache(maxsize=None)
def cache_folder() -> Path:
    """Return the folder of the compiled kernels for their present code and compiler."""
    versions = [importlib.metadata.version(name) for name in ("numba", "llvmlite", "rocket-fft")]
    versions += [str(sys.implementation.cache_tag), np.__version__.rpartition(".")[0]]
    versions += [str(numba.config.USING_SVML)]  # type: ignore[attr-defined]
    compiler = hashlib.sha256("\0".join(versions).encode()).hexdigest()[:8]
    return cache_root() / f"numba-{code_digest(*KERNEL_PARTS, titles=False)}-{compiler}"


@lru_cache(maxsize=None)
def _resolved_path(file: str) -> Path:
    """Return the path of a module without links; it is kept, because many kernels need it."""
    return Path(file).resolve()


class _Folder(_CacheLocator):
    """Location of a kernel's machine code in `cache_folder`, whose name identifies the code."""

    def __init__(self, function: Callable[..., Any], file: str):
        if _resolved_path(file).is_relative_to(PACKAGE):
            name = _resolved_path(file).parent.name
            self._stamp = ""
        else:  # the digest in the folder's name contains only the package
            name = self.get_suitable_cache_subpath(file)  # type: ignore[no-untyped-call]
            self._stamp = hashlib.sha256(Path(file).read_bytes()).hexdigest()
        self._path = cache_folder() / name

    def get_cache_path(self) -> str:
        return str(self._path)

    def get_source_stamp(self) -> str:
        return self._stamp

    def get_disambiguator(self) -> str:
        return ""

    @classmethod
    def from_function(cls, py_func: Callable[..., Any], py_file: str) -> "_Folder":
        return cls(py_func, py_file)


class _InFolder(CompileResultCacheImpl):
    """Writer of Numba's cache files, which do not depend on the line of a function in its source.

    The name of a file has the name of its function without the line, which a comment above it would
    change. The annotated source, which has paths of this machine, is left out.
    """

    _locator_classes = (_Folder,)  # type: ignore[assignment]

    def reduce(self, result: Any) -> tuple[Any, ...]:
        """Return the parts of a compiled function without its annotated source."""
        parts = super().reduce(result)  # type: ignore[no-untyped-call]
        return tuple("" if isinstance(part, str) else part for part in parts)

    def get_filename_base(self, fullname: str, abiflags: str) -> str:
        return super().get_filename_base(fullname, abiflags).replace(f"-{self._lineno}.", ".", 1)  # type: ignore[no-untyped-call]


def _runs_shipped_code(target: tuple[str, str, str]) -> bool:
    """Return whether a target of Numba (triple, processor, features) can run shipped code."""
    _, processor, features = target
    return processor == PROCESSOR or set(features.split(",")) >= FEATURES


class _KernelCache(FunctionCache):
    """Machine code of one kernel on the disk.

    The first compilation of a process is announced, and all are counted.
    """

    _impl_class = _InFolder
    misses = 0

    def __init__(self, function: Callable[..., Any]):
        super().__init__(function)  # type: ignore[no-untyped-call]
        path = SHIPPED / Path(self.cache_path).relative_to(cache_root())
        name = self._impl.filename_base
        stamp = self._impl.locator.get_source_stamp()
        self._shipped = IndexDataCacheFile(str(path), name, stamp)  # type: ignore[no-untyped-call]
        try:
            self._impl.locator.ensure_cache_path()
        except OSError:  # if nothing can be written, a process compiles what it needs
            self.disable()  # type: ignore[no-untyped-call]

    def announcement(self) -> str:
        """Say that kernels are compiled, and whether later processes will find them."""
        said = "jointclosure: compiling kernels that are new (up to two minutes of processor time)"
        if self._enabled:
            return f"{said}; later runs load them"
        where = f"{cache_folder()} cannot be written"
        return f"{said} in every process, as {where}; set JOINTCLOSURE_CACHE to a folder that can"

    def load_overload(self, sig, target_context):  # type: ignore[no-untyped-def]
        """Load the machine code for a signature, shipped code first; None if it must be compiled.

        It takes the place of Numba's `Cache.load_overload`. Only the runtime of Numba is
        initialised, not the registries of its compiler, which take a third of a second. A
        compilation loads these itself.
        """
        rtsys.initialize(target_context)
        key = self._index_key(sig, target_context.codegen())  # type: ignore[no-untyped-call]
        if _runs_shipped_code(key[1]):
            shipped = key[0], (key[1][0], PROCESSOR, ""), key[2]
            data = self._shipped.load(shipped)  # type: ignore[no-untyped-call]
            if data is not None:
                return self._impl.rebuild(target_context, data)
        with self._guard_against_spurious_io_errors():
            overload = self._load_overload(sig, target_context)  # type: ignore[no-untyped-call]
        if overload is None:
            _KernelCache.misses += 1
            if _KernelCache.misses == 1:  # because the process seems to hang
                logging.getLogger("jointclosure").warning(self.announcement())
        return overload


def compiles() -> int:
    """Return how often this process compiled a kernel instead of loading its machine code."""
    return _KernelCache.misses


def stored_kernels() -> tuple[int, int | None]:
    """Return the number of kernels whose machine code is stored, and the number of all kernels.

    The latter is None if it is not known. Shipped machine code counts as stored if this processor
    can run it.
    """
    folders = [cache_folder(), *_shipped_folder()]
    kernels = {kernel for folder in folders for kernel in _kernels_in(folder)}
    return len(kernels), max(filter(None, map(_stated_number, folders)), default=None)


def all_are_shipped() -> bool:
    """Return whether the machine code of all kernels is shipped for a processor like this one."""
    return any(_stated_number(folder) == len(_kernels_in(folder)) for folder in _shipped_folder())


def _shipped_folder() -> list[Path]:
    """Return the folder of the shipped kernels in a list, empty if they cannot run here."""
    runs = _runs_shipped_code(cpu_target.target_context.codegen().magic_tuple())
    return [SHIPPED / cache_folder().name] if runs else []


def _kernels_in(folder: Path) -> set[Path]:
    """Return the paths, within a folder, of the index files of kernels with machine code there."""
    return {file.relative_to(folder) for file in folder.rglob("*.nbi")}


def _stated_number(folder: Path) -> int | None:
    """Return the number of all kernels that is stored in a folder, None if there is none."""
    file = folder / _NUMBER
    return int(file.read_text(encoding="utf-8")) if file.is_file() else None


def store_number_of_kernels() -> None:
    """Store how many kernels have machine code now, as the number of all kernels.

    It is called only after all kernels were compiled, which is not checked here. Nothing is written
    if there is no cache folder.
    """
    if cache_folder().is_dir():  # it is absent if nothing can be written
        number, _ = stored_kernels()
        (cache_folder() / _NUMBER).write_text(f"{number}\n", encoding="utf-8")


def kernel(function: Callable[..., Any]) -> Callable[..., Any]:
    """Compile a numerical function as a kernel, whose machine code is copied into its callers.

    The code is cached on disk, serial, and in IEEE arithmetic: 0/0 raises nothing. A closure is
    named after the flags (bool) that it closes over. Without these, two closures of one factory,
    compiled in two processes, could have one name, and fail in a third process that loads both.
    """
    return _compile(function, inlined=True)


def large_kernel(function: Callable[..., Any]) -> Callable[..., Any]:
    """Compile a function as `kernel`, but without copying its machine code into its callers."""
    return _compile(function, inlined=False)


def _compile(function: Callable[..., Any], inlined: bool) -> Callable[..., Any]:
    """Compile a function with the cache on disk, named after the flags (bool) that it closes over.

    If Numba's compilation is disabled, a Python function that ignores floating-point warnings is
    returned.
    """
    cells = zip(function.__code__.co_freevars, function.__closure__ or (), strict=True)
    flags = [(name, cell.cell_contents) for name, cell in cells]
    function.__qualname__ += "".join(
        f"_{name}_{value}" for name, value in flags if isinstance(value, bool)
    )
    compiled = numba.njit(function, error_model="numpy", nogil=True, forceinline=inlined)
    if numba.config.DISABLE_JIT:  # type: ignore[attr-defined]
        return np.errstate(divide="ignore", invalid="ignore", over="ignore")(compiled)
    template = compiled.get_call_template
    # constants are arguments like others: one specialisation for all of them
    compiled.get_call_template = lambda args, kws: template(  # type: ignore[method-assign]
        [types.unliteral(arg) for arg in args],  # type: ignore[no-untyped-call]
        {name: types.unliteral(arg) for name, arg in kws.items()},  # type: ignore[no-untyped-call,union-attr]
    )
    # like `enable_caching`, which would use the folder set for the whole process
    compiled._cache = _KernelCache(function)  # type: ignore[attr-defined]
    # exceptions name a file: the module's name, so that machine code has no path of this machine
    name = f"{function.__module__}.py"
    function.__code__ = function.__code__.replace(co_filename=name)
    return compiled

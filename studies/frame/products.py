"""Products: files of a study, each with the function that makes them of what it reads.

The names of a function's parameters are those of the files and settings that it reads; their types
state how a file is read. A product is made again if one of these changes, or the code of the
function.
"""

import contextlib
import inspect
import typing
from collections.abc import Callable, Collection, Iterable, Mapping
from pathlib import Path
from typing import Any, NamedTuple

import pandas as pd

from jointclosure.compilation.sources import code_digest
from jointclosure.storage.files import read_csv, write

GIVEN = ("config", "folder", "workers", "log")
"""Parameters that every function may have: keys, folder of the study, number of processes, log."""
EARLY = 1
"""Priority of what is made before the pool of a study is closed."""


def figure_files(names: Iterable[str]) -> list[str]:
    """Return the files of figures, in every format."""
    return [f"figures/{name}.{format}" for format in ("png", "pdf") for name in names]


class Step(NamedTuple):
    """Files that one job makes, with the paths and settings that its function reads, by name.

    ``inputs`` without a parameter only precede it, and the times of those ``untimed`` do not count.
    It is made again if ``depends`` changes. Steps of a ``group`` in a row are one job of a cluster.
    """

    make: Callable[..., Any]
    files: list[str]
    inputs: Mapping[str, Any] = {}
    settings: Mapping[str, Any] = {}
    depends: Callable[[], str] = str
    untimed: Collection[str] = ()
    priority: int = 0
    all_cores: bool = False
    group: str | None = None

    @property
    def title(self) -> str:
        """First line of the function's documentation, without its full stop."""
        return str(inspect.getdoc(self.make)).splitlines()[0].rstrip(".")

    def params(self, depends: Any = None) -> dict[str, Any]:
        """Return the parameters of its rule; the given ``depends`` is called later."""
        name = f"{self.make.__module__}:{self.make.__name__}"
        return {
            "make": name,
            "settings": dict(self.settings),
            "depends": depends or self.depends(),
            "code": code_digest(name),
        }


class Product(NamedTuple):
    """Function that makes ``files`` of a study ``when`` it has them; ``apart``: if asked to."""

    make: Callable[..., Any]
    files: Callable[[Any], Iterable[str]]
    when: Callable[[Any], bool]
    priority: int
    apart: bool

    @property
    def folder(self) -> str:
        """Folder of `studies` to which the function belongs."""
        return self.make.__module__.split(".")[1]

    @property
    def reads(self) -> list[str]:
        """Names of the files and settings that the function reads."""
        return [name for name in inspect.signature(self.make).parameters if name not in GIVEN]


_DECLARED: dict[str, Product] = {}


def products_of(folder: str) -> dict[str, Product]:
    """Return the products of a folder by the names of their functions, in their order there."""
    return {name: product for name, product in _DECLARED.items() if product.folder == folder}


def product(
    *files: str,
    figures: Iterable[str] = (),
    listed: Callable[[Any], Iterable[str]] | None = None,
    when: Callable[[Any], bool] = lambda study: True,
    early: bool = False,
    apart: bool = False,
) -> Callable[[Callable], Callable]:
    """Declare that a function makes files, named here or ``listed`` of a study, and figures."""

    def declared(make: Callable) -> Callable:
        files_of = listed or (lambda study: (*files, *figure_files(figures)))
        _DECLARED[make.__name__] = Product(make, files_of, when, EARLY if early else 0, apart)
        return make

    return declared


def make_files(
    make: Callable[..., Any],
    inputs: Mapping[str, Any],
    settings: Mapping[str, Any],
    outputs: Iterable[str],
    **given: Any,
) -> None:
    """Call a function, and write what it returns: parts by order or by names of files.

    A figure is a part for each of its formats; a part may be a function that writes to a path.
    """
    hints = typing.get_type_hints(make, include_extras=True)
    paths = [Path(path) for path in outputs]
    with contextlib.ExitStack() as opened:
        read = {n: _read(hints[n], path, opened) for n, path in inputs.items() if n in hints}
        parts = make(**settings, **read, **{n: v for n, v in given.items() if n in hints})
    if parts is None:  # it wrote all itself
        return
    if isinstance(parts, dict):
        parts = [parts[path.name if path.name in parts else path.stem] for path in paths]
    else:
        parts = parts if isinstance(parts, tuple) else (parts,)
        parts *= len(paths) // len(parts)
    for path, part in zip(paths, parts, strict=True):
        part(path) if callable(part) else write(part, path)
        given["log"](f"wrote {path}")


def _read(hint: Any, path: Any, opened: contextlib.ExitStack) -> Any:
    """Read a file as its type states; no path gives None, several a list."""
    if typing.get_origin(hint) is list:
        return [_read(typing.get_args(hint)[0], one, opened) for one in path]
    kinds = [kind for kind in typing.get_args(hint) if kind is not type(None)]
    if type(None) in typing.get_args(hint):
        return _read(kinds[0], path, opened) if path else None
    if metadata := getattr(hint, "__metadata__", ()):
        value = metadata[0](path)
        return opened.enter_context(value) if hasattr(value, "__enter__") else value
    return read_csv(path) if hint is pd.DataFrame else path

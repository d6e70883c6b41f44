"""Products: files of a study, each with the function that makes it of what it reads.

The names of a function's parameters are those of the files and settings that it reads
(`studies.frame.plan`); their types state how a file is read. A product is made again if
one of these changes, or the code that its function uses, and not with any key of a configuration.
"""

import contextlib
import inspect
import typing
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import Any, NamedTuple

import pandas as pd

from jointclosure.compilation.sources import code_digest
from jointclosure.storage.files import read_csv, save_figure, write_csv, write_text
from jointclosure.storage.netcdf import write_netcdf

_WRITERS: dict[str, Callable[..., None]] = {
    **{".nc": write_netcdf, ".csv": write_csv, ".png": save_figure, ".pdf": save_figure},
    **dict.fromkeys((".json", ".tex", ".md", ".txt"), write_text),
}


class Product(NamedTuple):
    """Files of a study and the function that makes them.

    ``files`` gives their paths in the study's folder, and ``when`` whether a study has them, of a
    `studies.frame.plan.Plan`. ``early`` ones are made before the study's pool is closed; those that
    stand ``apart`` only if they are asked for.
    """

    make: Callable[..., Any]
    files: Callable[[Any], Iterable[str]]
    when: Callable[[Any], bool]
    early: bool
    apart: bool

    @property
    def name(self) -> str:
        """Name of its rule: that of the function."""
        return self.make.__name__

    @property
    def title(self) -> str:
        """First line of the function's documentation, without its full stop."""
        return str(inspect.getdoc(self.make)).splitlines()[0].rstrip(".")

    @property
    def code(self) -> str:
        """Digest of the function and of all code that it uses."""
        return code_digest(f"{self.make.__module__}:{self.name}")

    @property
    def reads(self) -> list[str]:
        """Names of the files and settings that the function reads."""
        return [name for name in inspect.signature(self.make).parameters if name != "log"]

    def write(
        self,
        inputs: Mapping[str, Any],
        settings: Mapping[str, Any],
        outputs: Iterable[str],
        log: Callable[[str], object],
    ) -> None:
        """Make the product and write its parts, by order or by stems of their paths."""
        hints, outputs = typing.get_type_hints(self.make, include_extras=True), list(outputs)
        with contextlib.ExitStack() as opened:
            read = {
                name: _read(hints[name], inputs[name], opened)
                for name in self.reads
                if name not in settings
            }
            parts = self.make(**settings, **read, **({"log": log} if "log" in hints else {}))
        if isinstance(parts, dict):
            parts = [parts[Path(path).stem] for path in outputs]
        for path, part in zip(outputs, parts if len(outputs) > 1 else [parts], strict=True):
            _WRITERS[Path(path).suffix](part, path)
            log(f"wrote {path}")


PRODUCTS: dict[str, Product] = {}
"""All products by the names of their functions, in the order of their definition."""


def product(
    *files: str,
    listed: Callable[[Any], Iterable[str]] | None = None,
    when: Callable[[Any], bool] = lambda plan: True,
    early: bool = False,
    apart: bool = False,
) -> Callable[[Callable], Callable]:
    """Declare that a function makes files, named here or ``listed`` of a plan."""

    def declared(make: Callable) -> Callable:
        PRODUCTS[make.__name__] = Product(make, listed or (lambda plan: files), when, early, apart)
        return make

    return declared


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

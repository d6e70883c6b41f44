"""Optional dependencies: the modules of each extra, and one clear error if one is missing."""

import importlib.metadata
import importlib.util
import warnings
from collections.abc import Iterator
from contextlib import contextmanager

from jointclosure.inputs import InputError

EXTRAS: dict[str, tuple[str, ...]] = {
    "exchange": ("meshio",),
    "figures": ("matplotlib", "seaborn"),
    "peers": ("ContactMechanics", "tamaas"),
    "report": ("jinja2",),
    "walls": ("SurfaceTopography", "rasterio", "trimesh"),
    "workflow": ("snakemake",),
}
"""Modules that each extra adds to the dependencies of the library, as they are imported."""


@contextmanager
def needs(extra: str, what: str) -> Iterator[None]:
    """Wrap imports of the modules of an extra; raise `InputError` if one of them is not installed.

    The message says how to install it, and that ``what`` needs it. Errors on modules that are not
    of the extra are not changed. An `ImportWarning` inside is not shown.
    """
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", ImportWarning)  # of what a module itself can do without
            yield
    except ModuleNotFoundError as error:
        module = (error.name or "").partition(".")[0]
        if module not in EXTRAS[extra]:
            raise
        raise InputError(
            f"{what} needs {module}, which is not installed: {installing(extra)}"
        ) from None


def installing(extra: str) -> str:
    """Return the pip command that installs the packages of an extra.

    It names them one by one, and so does not depend on how jointclosure was installed.
    """
    entries = (entry.split("; ") for entry in importlib.metadata.requires("jointclosure") or ())
    names = [entry[0] for entry in entries if entry[1:] == [f"extra == '{extra}'"]]
    return " ".join(["pip install", *(f"'{name}'" for name in names)])


def installed(extra: str) -> bool:
    """Return whether all modules of an extra are installed, without importing them."""
    return all(importlib.util.find_spec(module) is not None for module in EXTRAS[extra])

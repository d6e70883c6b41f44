"""Optional dependencies: what an extra is for, and one line where it is missing."""

import importlib.util
from collections.abc import Iterator
from contextlib import contextmanager

from jointclosure.inputs import InputError

EXTRAS: dict[str, tuple[str, ...]] = {
    "exchange": ("meshio",),
    "figures": ("matplotlib", "seaborn"),
    "peers": ("ContactMechanics", "tamaas"),
    "report": ("docutils", "jinja2", "plotly"),
    "walls": ("SurfaceTopography", "tifffile", "trimesh"),
    "workflow": ("mpmath", "snakemake"),
}
"""Modules that each extra adds to those of the library."""


@contextmanager
def needs(extra: str, what: str) -> Iterator[None]:
    """Around the imports of an extra's modules.

    Parameters
    ----------
    extra : str
        A name of `EXTRAS`.
    what : str
        What the modules are for, the first word of the message.

    Raises
    ------
    InputError
        A module is not installed; names it, and how to install the extra.
    """
    try:
        yield
    except ModuleNotFoundError as error:
        module = (error.name or "").partition(".")[0]
        if module not in EXTRAS[extra]:
            raise
        raise InputError(
            f"{what} needs {module}, which is not installed: pip install 'jointclosure[{extra}]'"
        ) from None


def installed(extra: str) -> bool:
    """Whether all modules of an extra are there."""
    return all(importlib.util.find_spec(module) is not None for module in EXTRAS[extra])

"""Closure of rough rock joints under normal load cycles.

The model is that of Rezaei Niya & Selvadurai, "Modeling the Approach of Non-mated
Rock Fracture Surfaces Under Quasi-static Normal Load Cycles". docs/model.md describes how it
is read here. All values are in SI units.

Public names are those of ``__init__.pyi``. They are imported when they are first used (SPEC 1 of
Scientific Python), so that ``import jointclosure`` takes almost no time.
"""

import lazy_loader

_public, _names, __all__ = lazy_loader.attach_stub(__name__, __file__)


def __getattr__(name: str) -> object:
    """Import a public name when it is first used, or return the installed version."""
    if name == "__version__":
        from importlib.metadata import version  # takes longer than all else here

        return version("jointclosure")
    return _public(name)


def __dir__() -> list[str]:
    return sorted([*_names(), "__version__"])

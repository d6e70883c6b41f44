"""Closure of rough rock joints under normal load cycles.

The model is that of Rezaei Niya & Selvadurai, "Modeling the Approach of Non-mated
Rock Fracture Surfaces Under Quasi-static Normal Load Cycles". docs/model.md describes how it
is read here. All values are in SI units.

Public names are imported when they are first used (PEP 562). Modules that are not used are
not loaded, and ``import jointclosure`` takes almost no time.
"""

import importlib
from typing import TYPE_CHECKING

if TYPE_CHECKING:  # type checkers and `compilation.sources` read these imports, Python does not
    from jointclosure.assessment.assess import assess
    from jointclosure.assessment.selection import choose_effects
    from jointclosure.ensembles.joints import simulate_ensemble
    from jointclosure.inputs import InputError
    from jointclosure.joint.conditions import Conditions
    from jointclosure.joint.simulation import equilibrium, simulate
    from jointclosure.measured.fit import fit
    from jointclosure.measured.region import validate
    from jointclosure.parameters import Choices, Effects, Numerics, Rock
    from jointclosure.plotting import plot
    from jointclosure.statistics.indifference import indifference_interval
    from jointclosure.uncertainty.scanned_joint import close
    from jointclosure.walls.scans import read_scan
    from jointclosure.walls.synthesis import wall_pair

    __version__: str

_MODULES = {
    "Choices": "parameters",
    "Conditions": "joint.conditions",
    "Effects": "parameters",
    "InputError": "inputs",
    "Numerics": "parameters",
    "Rock": "parameters",
    "assess": "assessment.assess",
    "choose_effects": "assessment.selection",
    "close": "uncertainty.scanned_joint",
    "equilibrium": "joint.simulation",
    "fit": "measured.fit",
    "indifference_interval": "statistics.indifference",
    "plot": "plotting",
    "read_scan": "walls.scans",
    "simulate": "joint.simulation",
    "simulate_ensemble": "ensembles.joints",
    "validate": "measured.region",
    "wall_pair": "walls.synthesis",
}
"""Module that defines each public name."""

__all__ = [
    "Choices",
    "Conditions",
    "Effects",
    "InputError",
    "Numerics",
    "Rock",
    "assess",
    "choose_effects",
    "close",
    "equilibrium",
    "fit",
    "indifference_interval",
    "plot",
    "read_scan",
    "simulate",
    "simulate_ensemble",
    "validate",
    "wall_pair",
]


if not TYPE_CHECKING:  # with it a type checker would accept any attribute name

    def __getattr__(name: str) -> object:
        """Import a public name when it is first used, or return the installed version."""
        if name == "__version__":
            from importlib.metadata import version

            value = version("jointclosure")
        elif name in _MODULES:
            module = importlib.import_module(f"{__name__}.{_MODULES[name]}")
            value = getattr(module, name, None) or importlib.import_module(
                f"{module.__name__}.{name}"
            )
        else:
            raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
        globals()[name] = value
        return value


def __dir__() -> list[str]:
    return sorted([*__all__, "__version__"])

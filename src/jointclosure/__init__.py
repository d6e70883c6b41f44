"""Closure of rough rock joints under normal load cycles.

The model of Rezaei Niya & Selvadurai, "Modeling the Approach of Non-mated
Rock Fracture Surfaces Under Quasi-static Normal Load Cycles", as read in
docs/model.md. SI units throughout.
"""

from importlib.metadata import version

from jointclosure.inputs import InputError
from jointclosure.parameters import (
    Choices,
    Effects,
    Numerics,
    Rock,
)
from jointclosure.simulation import equilibrium, simulate
from jointclosure.statistics.indifference import indifference_interval
from jointclosure.studies.effects.choice import choose_effects
from jointclosure.surface.synthesis import wall_pair

__version__ = version("jointclosure")

__all__ = [
    "Choices",
    "Effects",
    "InputError",
    "Numerics",
    "Rock",
    "choose_effects",
    "equilibrium",
    "indifference_interval",
    "simulate",
    "wall_pair",
]

"""The properties of a rock that a study can vary: their units and names, in one table."""

from typing import NamedTuple

from jointclosure.config.units import SI_FACTORS


class Property(NamedTuple):
    """A property of a rock as it is shown: its unit ("1" for none), and its names.

    ``label`` and ``latex`` head its row of Table 3, with its symbol and unit.
    """

    unit: str
    long_name: str
    label: str
    latex: str

    @property
    def title(self) -> str:
        """Its name at the head of a column."""
        return self.long_name[0].upper() + self.long_name[1:]

    @property
    def size(self) -> float:
        """The unit in SI."""
        return SI_FACTORS.get(self.unit, 1.0)

    @property
    def si_unit(self) -> str:
        """The unit that it has in a dataset."""
        return {"GPa": "Pa", "MPa": "Pa", "mm": "m", "um": "m"}.get(self.unit, self.unit)

    @property
    def in_brackets(self) -> str:
        """The unit behind a title: " (GPa)", or nothing."""
        return "" if self.unit == "1" else f" ({self.unit})"


PROPERTIES = {
    "poisson_ratio": Property(
        "1", "Poisson's ratio", "Poisson's ratio ν", r"Poisson's ratio $\nu$"
    ),
    "youngs_modulus": Property(
        "GPa", "Young's modulus", "Young's modulus E (GPa)", r"Young's modulus $E$ (GPa)"
    ),
    "compressive_strength": Property(
        "MPa",
        "compressive strength",
        "Compressive strength σc (MPa)",
        r"Compressive strength $\sigma_c$ (MPa)",
    ),
    "jrc": Property(
        "1", "JRC", "Joint roughness coefficient (JRC)", "Joint roughness coefficient (JRC)"
    ),
}
"""By name, in the order of the paper's Table 3."""
PARAMETERS = tuple(PROPERTIES)
PARAMETER_TITLES = {name: each.title for name, each in PROPERTIES.items()}


def key_of(name: str) -> str:
    """The key of a property in a configuration, with its unit."""
    unit = PROPERTIES[name].unit
    return name if unit == "1" else f"{name}_{unit}"

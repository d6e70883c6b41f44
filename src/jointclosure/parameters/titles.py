"""Properties that a study can vary, with their names in tables, figures and datasets."""

from jointclosure.parameters import PROPERTIES, key_of

__all__ = ["PARAMETERS", "PARAMETER_TITLES", "PROPERTIES", "key_of"]

PARAMETERS = tuple(PROPERTIES)
PARAMETER_TITLES = {name: about.title for name, about in PROPERTIES.items()}

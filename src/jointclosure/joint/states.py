"""What a joint is at one step: the fields that follow from its walls and forces."""

from typing import NamedTuple

import numpy as np

from jointclosure.solvers.interaction_operator import interaction_field
from jointclosure.solvers.joint import Joint


class Fields(NamedTuple):
    """Of the cells (y, x) [m]: displacement by all other contacts, and overlap of the walls.

    ``overlap`` is delta_S, negative where the walls are apart: there it is the aperture.
    """

    displacement: np.ndarray
    overlap: np.ndarray

    @property
    def aperture(self) -> np.ndarray:
        """Distance of the walls (y, x) [m], 0 where they are pressed together."""
        return np.maximum(-self.overlap, 0.0)


def fields_of(joint: Joint, closure: float) -> Fields:
    """Fields of a joint at rest at a closure [m], from its walls and forces."""
    if joint.interaction_acts:
        displacement = interaction_field(joint.influence, joint.force)
    else:
        displacement = np.zeros(joint.upper.shape)
    overlap = joint.upper + joint.lower + (closure - joint.first_touch) - displacement
    return Fields(displacement, overlap)

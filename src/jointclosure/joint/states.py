"""Fields of a joint at one step, computed from its walls and forces."""

from typing import NamedTuple

import numpy as np

from jointclosure.solvers.interaction_operator import interaction_field
from jointclosure.solvers.joint import Joint


class Fields(NamedTuple):
    """Fields on the cells (y, x) [m]: displacement by all other contacts, and overlap of the walls.

    ``overlap`` is delta_S. It is negative where the walls are apart; its size is the aperture
    there.
    """

    displacement: np.ndarray
    overlap: np.ndarray

    @property
    def aperture(self) -> np.ndarray:
        """Distance of the walls (y, x) [m], 0 where they are in contact."""
        return np.maximum(-self.overlap, 0.0)


def fields_of(joint: Joint, closure: float) -> Fields:
    """Compute the fields of a joint at rest at a closure [m] from its walls and forces."""
    if joint.interaction_acts:
        displacement = interaction_field(joint.influence, joint.force)
    else:
        displacement = np.zeros(joint.upper.shape)
    overlap = joint.upper + joint.lower + (closure - joint.first_touch) - displacement
    return Fields(displacement, overlap)

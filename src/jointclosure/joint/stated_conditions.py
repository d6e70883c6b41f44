"""Check of the conditions that a user states, at the door of every public function.

It needs the strength of cells, and with it the mechanics. Modules that only hold conditions, such
as those that make surfaces, do not depend on these (`jointclosure.joint.conditions`).
"""

from collections.abc import Sequence

from jointclosure.joint.checked_conditions import CheckedConditions
from jointclosure.joint.conditions import Conditions
from jointclosure.joint.feasibility import check_strength
from jointclosure.parameters import check_effective


def check_carried(checked: CheckedConditions) -> None:
    """Raise `InputError` if no walls of the rocks can carry the stress of checked conditions."""
    check_strength(checked.rock, checked.largest_stress, *checked.model, checked.spacing)


def checked_as_stated(
    stated: Conditions, snapshots: Sequence[float] = (), varied: bool = False
) -> CheckedConditions:
    """Check the conditions that a user states, once for each call of a public function.

    Return them as `Conditions.checked` does. Raise `InputError` if a value is not allowed, if no
    walls of the rocks carry the stress, or if a setting was changed that has no effect
    (`check_effective`). ``snapshots`` are stresses [Pa]. ``varied`` is whether the function also
    simulates joints with fewer effects.
    """
    checked = stated.checked(snapshots)
    check_carried(checked)
    check_effective(*checked.model, varied=varied)
    return checked

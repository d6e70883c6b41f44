"""Option `--animation` of the commands that close a joint: more snapshots, and a GIF of them."""

import numpy as np
import xarray as xr

from jointclosure.joint.conditions import Conditions
from jointclosure.joint.loading import largest_stress
from jointclosure.storage.figures import save_animation


def kept_stresses(arguments, conditions: Conditions) -> tuple[float, ...]:
    """Return the stresses [Pa] of the requested snapshots and of the frames of an animation."""
    if arguments.animation is None:
        return arguments.snapshots
    from jointclosure.plotting.animation import animated_stresses

    largest = largest_stress(conditions.max_normal_stress)
    return (*arguments.snapshots, *animated_stresses(largest))


def write_animation(closed: xr.Dataset, arguments, title: str) -> xr.Dataset:
    """Write the animation, if requested; return the joint with only the requested snapshots."""
    if arguments.animation is None:
        return closed
    from jointclosure.plotting.animation import crushing_animation

    if closed.sizes["snapshot"]:
        save_animation(crushing_animation(closed, title), arguments.animation)
        print(f"wrote {arguments.animation}")
    if not arguments.snapshots:
        about = [name for name in closed.variables if str(name).startswith("snapshot_")]
        return closed.drop_vars([*about, "upper_first", "lower_first"], errors="ignore")
    asked = np.isin(closed.snapshot_stress.values, arguments.snapshots)
    return closed.isel(snapshot=asked)

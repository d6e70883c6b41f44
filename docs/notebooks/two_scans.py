# %% [markdown]
# # A joint from two scans
#
# Two files of points, one for each wall, become a joint that is pressed together and released.
# No scan comes with the package, so the first cell writes two: walls of JRC 8 whose waves longer
# than 3 mm mate, as files of a scanner would have them, in millimetres and in one frame.

# %%
import tempfile
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import jointclosure as jc

spacing, shape = 0.25e-3, (56, 64)
walls = {"mismatch_wavelength": 3e-3, "roll_off": None}  # natural walls have waves of all lengths
upper, lower = jc.wall_pair(8, shape, spacing, seed=4, **walls)
folder = Path(tempfile.mkdtemp())
y, x = np.indices(shape) * spacing
for name, heights in (("upper", 1e-3 - upper), ("lower", lower)):  # z upwards in both
    points = 1e3 * np.column_stack([x.ravel(), y.ravel(), heights.ravel()])
    np.savetxt(folder / f"{name}.xyz", points, fmt="%.6f")

# %% [markdown]
# `read_scan` reports what is in a file. Units that a file does not state must be given.

# %%
jc.read_scan(folder / "upper.xyz", units="mm")

# %% [markdown]
# `close` brings both walls together, checks how they lie, and closes them. It keeps the joint's
# state at 1 and 10 MPa.

# %%
joint = jc.close(
    folder / "upper.xyz",
    folder / "lower.xyz",
    units="mm",
    rock="granite",
    max_normal_stress=10e6,
    snapshots=[1e6, 10e6],
)
print(joint)
print("\n".join(f"- {line}" for line in joint.pair.remarks))

# %% [markdown]
# How far the joint closes is known to a range only, by errors of the scans and of the numerics. A
# wider range has other choices of the model too.

# %%
print("\n".join(joint.budget.tables()))
print("\n".join(f"- {line}" for line in joint.budget.sentences()))

# %% [markdown]
# The walls at first touch, in a section, and the curves. Laboratory curves start at a seating
# stress: so do these, in each cycle.

# %%
figure, panels = plt.subplots(1, 3, figsize=(12, 3.6), layout="constrained")
jc.plot.walls(joint, axes=panels[0])
jc.plot.curves(joint, panels[1], since="seating")
jc.plot.stiffness(joint, panels[2])
plt.show()

# %% [markdown]
# Where the walls touch at 10 MPa, and what has broken by then. Snapshots are there in the order in
# which they came, with the cycle and the branch on which they were passed.

# %%
history = joint.history
for place in range(history.sizes["snapshot"]):
    state = history.isel(snapshot=place)
    stress, branch = 1e-6 * state.snapshot_stress.item(), state.snapshot_branch.item()
    print(f"{place}: {stress:g} MPa, cycle {state.snapshot_cycle.item()}, {branch}")

figure, panels = plt.subplots(1, 2, figsize=(10, 3.8), layout="constrained")
jc.plot.aperture(joint, 1, panels[0])
jc.plot.damage(joint, 1, panels[1])
plt.show()

# %% [markdown]
# A load history has several maxima and partial unloading: the stresses at which the load turns.

# %%
loaded = jc.close(
    folder / "upper.xyz",
    folder / "lower.xyz",
    units="mm",
    rock="granite",
    max_normal_stress=[4e6, 1e6, 8e6, 2e6, 12e6],
    single=True,
)
axes = jc.plot.curves(loaded)
plt.show()

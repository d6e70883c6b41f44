# %% [markdown]
# # One joint
#
# Two random walls of JRC 8 are pressed together to 10 MPa and released, twice. All lengths are
# in metres and stresses in pascal.

# %%
import jointclosure as jc

spacing = 0.25e-3
upper, lower = jc.wall_pair(jrc=8, shape=(50, 50), spacing=spacing, seed=1)
dolerite = jc.Rock(youngs_modulus=78e9, poisson_ratio=0.2, compressive_strength=165e6)
joint = jc.simulate(upper, lower, spacing=spacing, rock=dolerite, max_normal_stress=10e6)
joint

# %% [markdown]
# Every step of the simulation is there. The maximum closure of a cycle is counted from where
# the cycle began.

# %%
for cycle, closure in enumerate(1e3 * joint.max_closure.values, start=1):
    print(f"cycle {cycle}: {closure:.4f} mm")

# %% [markdown]
# The first cycle breaks asperities. The second is far stiffer.

# %%
import matplotlib.pyplot as plt

figure, axes = plt.subplots(figsize=(6, 4), layout="constrained")
for cycle in (1, 2):
    own = joint.isel(step=joint.load_cycle.values == cycle)
    axes.plot(1e3 * own.closure, 1e-6 * own.normal_stress, label=f"cycle {cycle}")
axes.set(xlabel="closure from first touch (mm)", ylabel="normal stress (MPa)")
axes.legend(frameon=False)
plt.show()

# %% [markdown]
# Effects can be left out. Without breakage there is no history: loading and unloading are one
# curve.

# %%
elastic = jc.simulate(
    upper,
    lower,
    spacing=spacing,
    rock=dolerite,
    max_normal_stress=10e6,
    effects=jc.Effects(breakage=False, gouge=False),
)
print(f"{1e3 * float(elastic.max_closure[0]):.4f} mm without breakage")

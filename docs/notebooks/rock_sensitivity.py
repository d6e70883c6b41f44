# %% [markdown]
# # What a rock's closure is sensitive to
#
# Twelve small joints of dolerite are closed to 5 MPa twice, with its properties 10 % higher and
# lower one at a time. The walls are the same in every case, so that differences between cases are
# of the property alone.

# %%
import matplotlib.pyplot as plt
import numpy as np

import jointclosure as jc

spacing, seeds = 0.25e-3, range(12)
dolerite = jc.Rock(youngs_modulus=78e9, poisson_ratio=0.2, compressive_strength=165e6)


def walls(seed, jrc=8.0):
    return jc.wall_pair(jrc, (24, 24), spacing, seed)


def closures(rule=walls, rock=dolerite):
    """Maximum closures (realization, cycle) [mm]."""
    ensemble = jc.simulate_ensemble(
        rule, seeds=seeds, spacing=spacing, rock=rock, max_normal_stress=5e6
    )
    return 1e3 * ensemble.max_closure.values


base = jc.simulate_ensemble(
    walls, seeds=seeds, spacing=spacing, rock=dolerite, max_normal_stress=5e6
)
jc.plot.curves(base)
plt.show()

# %% [markdown]
# An elasticity is by how many percent closure changes where a property rises by one: the
# logarithmic derivative, here of each joint between 0.9 and 1.1 times the property.

# %%
change, elasticities = 0.1, {}
for name in dolerite._fields:
    value = getattr(dolerite, name)
    higher, lower = (
        closures(rock=dolerite._replace(**{name: value * factor}))
        for factor in (1.0 + change, 1.0 - change)
    )
    elasticities[name] = np.log(higher / lower) / np.log((1.0 + change) / (1.0 - change))
rougher, smoother = (
    closures(lambda seed, jrc=factor * 8.0: walls(seed, jrc))
    for factor in (1.0 + change, 1.0 - change)
)
elasticities["JRC"] = np.log(rougher / smoother) / np.log((1.0 + change) / (1.0 - change))
for name, values in elasticities.items():
    means = values.mean(axis=0)
    errors = values.std(axis=0, ddof=1) / np.sqrt(len(values))
    text = ", ".join(
        f"{mean:+.2f} ± {error:.2f}" for mean, error in zip(means, errors, strict=True)
    )
    print(f"{name:21} {text}  (cycle 1, cycle 2)")

# %% [markdown]
# Breakage makes single joints jump between histories, which is why twelve of them are closed and
# errors are told.

# %%
figure, axes = plt.subplots(figsize=(6.5, 3.6), layout="constrained")
places = np.arange(len(elasticities))
for cycle, shift in ((0, -0.15), (1, 0.15)):
    means = [values[:, cycle].mean() for values in elasticities.values()]
    errors = [
        values[:, cycle].std(ddof=1) / np.sqrt(len(seeds)) for values in elasticities.values()
    ]
    axes.errorbar(means, places + shift, xerr=errors, fmt="os"[cycle], label=f"cycle {cycle + 1}")
axes.axvline(0.0, color="0.6", lw=0.8)
axes.set_yticks(places, [name.replace("_", " ") for name in elasticities])
axes.set_xlabel("elasticity of the maximum closure (mean and standard error)")
axes.legend(frameon=False)
plt.show()

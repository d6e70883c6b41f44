# %% [markdown]
# # Indifference intervals
#
# Within its indifference interval a rock property can change without a significant change of
# the mean maximum closure.
# Here Young's modulus of a small joint is varied over five levels. Ten pairs of walls are far
# fewer than a study takes: this shows how it is done.

# %%
import numpy as np

import jointclosure as jc

spacing, pairs = 0.25e-3, 10
levels = np.array([50e9, 64e9, 78e9, 92e9, 106e9])
walls = [jc.wall_pair(jrc=8, shape=(24, 24), spacing=spacing, seed=seed) for seed in range(pairs)]


def second_closure(modulus, upper, lower):
    """Maximum closure of the second cycle to 5 MPa (mm)."""
    rock = jc.Rock(modulus, poisson_ratio=0.2, compressive_strength=165e6)
    closed = jc.simulate(upper, lower, spacing=spacing, rock=rock, max_normal_stress=5e6)
    return 1e3 * float(closed.max_closure[1])


closures = np.array([[second_closure(level, *pair) for pair in walls] for level in levels])
means, deviations = closures.mean(axis=1), closures.std(axis=1, ddof=1)
for level, mean, deviation in zip(levels, means, deviations, strict=True):
    print(f"E = {1e-9 * level:3.0f} GPa: {mean:.4f} mm, standard deviation {deviation:.4f} mm")

# %% [markdown]
# Quadratics are fitted to means and deviations, and a t test compares each level with the
# rock's own (78 GPa).

# %%
found = jc.indifference_interval(1e-9 * levels, means, deviations, samples=pairs, base=78.0)
print(f"length of the interval: {found.length:.1f} GPa")
print("extrapolated beyond the levels" if found.extrapolated else "within the levels")

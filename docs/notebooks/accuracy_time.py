# %% [markdown]
# # Accuracy against time
#
# Steps of displacement and breakage are the paper's by default. Shorter ones take more time and are
# nearer to the limit of ever shorter ones. How much nearer, and is there a limit? Eight small
# joints are closed with the paper's steps times 2, 1, 1/2, 1/4 and 1/8.

# %%
import matplotlib.pyplot as plt
import numpy as np

import jointclosure as jc

spacing, seeds = 0.25e-3, range(8)
factors = [2.0, 1.0, 0.5, 0.25, 0.125]
load = {"spacing": spacing, "rock": "granite", "max_normal_stress": 5e6}
paper = jc.Numerics()


def walls(seed):
    return jc.wall_pair(8, (24, 24), spacing, seed)


def closed(factor, seeds=seeds, **model):
    steps = {
        name: factor * getattr(paper, name) for name in paper._fields if name.endswith("_step")
    }
    numerics = paper._replace(**steps, **model)
    # with one worker no other process disturbs the times
    return jc.simulate_ensemble(walls, seeds=seeds, numerics=numerics, workers=1, **load)


for breakage in ("fixed_step", "resolved"):  # compiles, so that no joint below is timed with it
    closed(1.0, seeds=range(1), breakage=breakage)
runs = {factor: closed(factor) for factor in factors}
resolved = {factor: closed(factor, breakage="resolved") for factor in factors}

# %% [markdown]
# Means over the same walls are compared: breakage lets single joints jump. The error is that to
# the shortest steps, with the standard error of the difference.

# %%
for name, found in (("fixed breakage step", runs), ("resolved breakage", resolved)):
    print(name)
    best = found[factors[-1]].max_closure.values
    for factor in factors:
        closure = found[factor].max_closure.values
        seconds = float(found[factor].timing_simulation.mean())
        off = 100.0 * (closure / best - 1.0)
        errors = off.std(axis=0, ddof=1) / np.sqrt(len(off))
        text = ", ".join(
            f"{m:+5.1f} ± {e:.1f} %" for m, e in zip(off.mean(axis=0), errors, strict=True)
        )
        print(f"  steps x {factor:<5g} {seconds:6.2f} s a joint; cycles 1 and 2: {text}")

# %%
figure, axes = plt.subplots(figsize=(6.5, 3.8), layout="constrained")
for name, found, style in (("fixed", runs, "o-"), ("resolved", resolved, "s--")):
    seconds = [float(found[factor].timing_simulation.mean()) for factor in factors]
    for cycle in (0, 1):
        means = [1e3 * float(found[factor].max_closure[:, cycle].mean()) for factor in factors]
        axes.plot(seconds, means, style, color=f"C{cycle}", label=f"{name}, cycle {cycle + 1}")
axes.set(xscale="log", ylim=0.0, xlabel="processor time of a joint (s)", ylabel="mean closure (mm)")
axes.legend(frameon=False)
plt.show()

# %% [markdown]
# What this says of joints of the paper's size, with errors, is in [accuracy](../accuracy.md). Times
# are of the machine on which this site was built.

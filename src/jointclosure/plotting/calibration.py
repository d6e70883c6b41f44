"""Figure of a joint fitted to its measured closure: readings and likelihood over wavelength."""

import numpy as np
from matplotlib.figure import Figure

from jointclosure.measured.fit import Fit
from jointclosure.plotting.style import decimal_ticks, styled, subplots


@styled
def fit_figure(result: Fit, title: str) -> Figure:
    """Draw the measured readings among those of the joints, and the likelihood of wavelengths.

    Parameters
    ----------
    result : Fit
    title : str
    """
    figure, (above, below) = subplots(2, 1, figsize=(6.4, 6.4), sharex=True, height_ratios=(2, 1))
    tried = result.likelihood.wavelengths
    nodes = 1e3 * np.geomspace(tried[0], tried[-1], len(result.simulated))
    names = _names(result)
    for number, name in enumerate(names):
        closed = 1e3 * np.exp(result.simulated[..., number]).reshape(len(nodes), -1)
        colour = f"C{number % 10}"
        across = np.broadcast_to(nodes[:, None], closed.shape)
        above.plot(across.ravel(), closed.ravel(), ".", ms=3, color=colour, alpha=0.5)
        above.axhline(1e3 * result.measured.values[number], color=colour, lw=1.1, label=name)
    above.set(yscale="log", title=title, ylabel="closure (mm)")
    above.legend(
        frameon=False, fontsize=8, title="lines: measured\ndots: simulated",
        loc="upper left", bbox_to_anchor=(1.0, 1.0),
    )  # fmt: skip
    profile = result.likelihood.log.max(axis=1)
    below.plot(1e3 * result.likelihood.wavelengths, profile - profile.max(), color="C0")
    if result.interval_holds:
        low, high = np.clip(1e3 * np.array(result.mismatch_wavelength[1:]), nodes[0], nodes[-1])
        below.axvspan(low, high, color="0.9", lw=0.0, label="95 % interval")
    else:
        below.plot([], [], " ", label="the model does not explain this curve: no interval is valid")
    below.set(xscale="log", ylim=(-12.0, 1.0), ylabel="log likelihood")
    below.set_xlabel("mismatch wavelength (mm)")
    below.legend(frameon=False, loc="lower right")
    decimal_ticks(below.xaxis)
    return figure


def _names(result: Fit) -> list[str]:
    """Return names of the readings, in their order."""
    names = []
    for cycle in range(1, result.measured.cycles + 1):
        names += [f"cycle {cycle} to {1e-6 * level:.3g} MPa" for level in result.measured.levels]
        if cycle in result.measured.unloaded:
            names.append(f"cycle {cycle} recovered")
    return names

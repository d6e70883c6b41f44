"""Measured closure curves and best-fitting realisations in a panel of the closure figure."""

from collections.abc import Collection, Mapping
from types import MappingProxyType
from typing import NamedTuple

import pandas as pd
import seaborn as sns
import xarray as xr

from jointclosure.engine.aggregation import since_seating
from jointclosure.measured.curves import FIT_COLUMNS, MeasuredCurve, best_fits
from jointclosure.plotting.style import key
from jointclosure.statistics.standard_errors import percent

_MARKERS = "osD^v"
_DARK = dict(enumerate(sns.color_palette("dark", 8), start=1))


class Measurements(NamedTuple):
    """Measured curves by rock, and the fits of `jointclosure.measured.curves.fit_table`."""

    curves: Mapping[str, MeasuredCurve] = MappingProxyType({})
    fits: pd.DataFrame = pd.DataFrame(columns=FIT_COLUMNS)

    @property
    def cycles(self) -> int:
        """Return the last measured cycle, 0 if there is none."""
        return max((curve.cycles[-1] for curve in self.curves.values()), default=0)

    @property
    def best(self) -> list[int]:
        """Return the realisations that fit a curve best, which are always drawn."""
        return self.fits.best_realization.dropna().astype(int).tolist()


def draw_measured(
    axes,
    measured: Measurements,
    rock: str,
    base: xr.Dataset,
    seating_stress: float,
    cycles: Collection[int],
) -> str:
    """Draw a rock's measured curve and each cycle's best realisation, and describe the misfit.

    Parameters
    ----------
    axes : Axes
        Net closure [mm] since seating, and stress [MPa].
    measured : Measurements
    rock : str
        Nothing is drawn for a rock without a measured curve.
    base : Dataset
        The rock's base case, over (realization, cycle, branch, stress).
    seating_stress : float
        Stress from which closure of each cycle counts [Pa].
    cycles : collection of int
        Cycles that are drawn.

    Returns
    -------
    str
        A line for the title, empty without a measured curve.
    """
    if rock not in measured.curves:
        return ""
    curve = measured.curves[rock]
    for cycle in set(curve.cycles) & set(cycles):
        closures, stresses = [0.0], [seating_stress]
        for _, stress, closure in curve.since_seating(cycle, seating_stress):
            closures += closure.tolist()
            stresses += stress.tolist()
        axes.plot([1e3 * c for c in closures], [1e-6 * s for s in stresses], "k-", lw=1.6, zorder=5)
    net, misfits = since_seating(base), []
    for cycle, realization, misfit, misfit_percent in best_fits(measured.fits, rock):
        misfits.append(f"cycle {cycle} {misfit:.2g} mm ({percent(0.01 * misfit_percent)})")
        if cycle not in cycles:
            continue
        best = 1e3 * net.sel(cycle=cycle, realization=realization)
        for branch in ("loading", "unloading"):
            shown = base.stress.values > (seating_stress if branch == "loading" else -1.0)
            axes.plot(
                best.sel(branch=branch).values[shown],
                1e-6 * base.stress.values[shown],
                **_style(cycle),
            )
    if not misfits:
        return "\nno realisation reaches all measured stresses"
    return f"\nRMS misfit of the best: {', '.join(misfits)}"


def _style(cycle: int) -> dict:
    return {
        "color": _DARK[1 + (cycle - 1) % len(_DARK)],
        "ls": "",
        "marker": _MARKERS[(cycle - 1) % len(_MARKERS)],
        "ms": 3.2,
        "markevery": 2,
        "zorder": 4,
    }


def measured_handles(measured: Measurements) -> list:
    """Return entries of the legend; none without measured curves."""
    if not measured.curves:
        return []
    cycles = range(1, measured.cycles + 1)
    return [
        key(color="0.1", lw=1.6, label="measured curve"),
        *(key(label=f"surface that fits cycle {cycle} best", **_style(cycle)) for cycle in cycles),
    ]

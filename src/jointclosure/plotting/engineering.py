"""Engineering figure of a closed joint: closure since seating, stiffness, aperture."""

import numpy as np
import seaborn as sns
import xarray as xr
from matplotlib.figure import Figure

from jointclosure.joint.curves import curve_table, has_flow
from jointclosure.joint.laws import LAWS, fitted_laws, law_curves, law_words
from jointclosure.joint.protocol import LOADING
from jointclosure.plotting.joint import draw_stiffness
from jointclosure.plotting.style import BRANCH_LINES, above, styled, subplots


@styled
def engineering_figure(history: xr.Dataset, title: str) -> Figure:
    """Draw net closure since seating with the fitted laws, net stiffness and apertures.

    For a history with flow there is a further panel of hydraulic apertures.

    Parameters
    ----------
    history : Dataset
        As from `jointclosure.simulate`.
    title : str
    """
    shape, size = ((2, 2), (10.4, 8.4)) if has_flow(history) else ((1, 3), (13.5, 4.6))
    figure, panels = subplots(*shape, figsize=size)
    panels = panels.ravel()
    _draw_closure(panels[0], history)
    draw_stiffness(panels[1], history)
    panels[1].set_title("normal stiffness, by chords")
    _draw_aperture(panels[2], history)
    if has_flow(history):
        _draw_flow(panels[3], history)
        panels[3].set_ylim(0.0, max(axes.get_ylim()[1] for axes in panels[2:]))
        panels[2].set_ylim(panels[3].get_ylim())
    figure.suptitle(title, parse_math=False)
    for axes in panels:
        sns.despine(ax=axes)
    return figure


def _draw_closure(axes, history: xr.Dataset) -> None:
    """Draw loading of each cycle from its seating, and the fitted laws."""
    seating = 1e-6 * float(history.attrs["seating_stress_Pa"])
    fits = fitted_laws(history)
    for (cycle, branch), (stress, closure) in law_curves(history).items():
        if branch != LOADING:
            continue
        axes.plot(closure, stress, color=f"C{cycle - 1}", lw=2.2, label=f"cycle {cycle}")
        for style, name in zip((":", "-.", "--"), LAWS, strict=True):
            rows = fits[(fits.cycle == cycle) & (fits.branch == branch) & (fits.law == name)]
            law = LAWS[name].closure(stress, seating, *rows.value)
            axes.plot(law, stress, style, color="0.25", lw=1.0)
    for style, name in zip((":", "-.", "--"), LAWS, strict=True):
        axes.plot([], [], style, color="0.25", lw=1.0, label=law_words(name))
    axes.set(
        title="loading, and laws fitted to it", ylim=0.0,
        xlabel=f"net closure since {seating:g} MPa (mm)", ylabel="normal stress (MPa)",
    )  # fmt: skip
    axes.legend(frameon=False, fontsize=9)


def _draw_aperture(axes, history: xr.Dataset) -> None:
    """Draw mean aperture over stress from seating on, which leaves out the first contacts."""
    seating = 1e-6 * float(history.attrs["seating_stress_Pa"])
    table = curve_table(history)
    top = 0.0
    for (cycle, branch), rows in table.groupby(["cycle", "branch"], sort=False):
        axes.plot(
            rows.normal_stress_MPa, rows.mean_aperture_mm, BRANCH_LINES[branch],
            color=f"C{cycle - 1}", label=f"cycle {cycle}, {branch}",
            zorder=above(cycle, branch),
        )  # fmt: skip
        loaded = rows[rows.normal_stress_MPa >= 0.5 * seating].mean_aperture_mm
        top = max(top, float(np.nanmax(loaded)) if len(loaded) else 0.0)
    axes.set(
        title="mean aperture", xlim=0.0, ylim=(0.0, 1.15 * top or None),
        xlabel="normal stress (MPa)", ylabel="mean aperture (mm)",
    )  # fmt: skip
    axes.legend(frameon=False, fontsize=9)


def _draw_flow(axes, history: xr.Dataset) -> None:
    """Draw hydraulic apertures over stress by direction: loading thick, unloading thin."""
    for (cycle, branch), rows in curve_table(history).groupby(["cycle", "branch"], sort=False):
        for direction, style in (("x", "-"), ("y", ":")):
            label = f"cycle {cycle}, along {direction}" if branch == LOADING else None
            axes.plot(
                rows.normal_stress_MPa, rows[f"hydraulic_aperture_{direction}_mm"], style,
                color=f"C{cycle - 1}", label=label, lw=2.2 if branch == LOADING else 0.9,
                zorder=above(cycle, branch),
            )  # fmt: skip
    axes.set(
        title="hydraulic aperture (unloading thin)", xlim=0.0,
        xlabel="normal stress (MPa)", ylabel="hydraulic aperture (mm)",
    )  # fmt: skip
    axes.legend(frameon=False, fontsize=9)

"""Figures of a study and of its pool, as PNG and PDF.

Functions import what draws, which takes a second, as rules are made of this module in every run.
"""

from collections.abc import Callable, Iterable
from typing import Annotated, Any

import numpy as np
import pandas as pd
import xarray as xr

from jointclosure.engine.settings import SurfaceSettings, check_settings
from jointclosure.storage.netcdf import read_netcdf, reading_netcdf
from jointclosure.storage.text import read_text
from studies.frame.config.typed import StudyRock
from studies.frame.measured_files import CurveSettings, measured_curves
from studies.frame.products.frame import product
from studies.paper.sensitivity_tables import roughness_title


def _files(names: Iterable[str]) -> list[str]:
    """Files of figures, in the order in which the report shows them."""
    return [f"figures/{name}.{format}" for format in ("png", "pdf") for name in names]


def _of_study(plan: Any) -> list[str]:
    names = ["fig_3_equivalent_stress", "fig_5_closure", "closure_since_seating", "wall_pair"]
    names += ["hydraulic_aperture"] if plan.typed.flow else []
    return _files(names + (["table_3_intervals", "trends_max_closure"] if plan.varied else []))


@product(listed=_of_study, early=True)
def draw_figures(
    study: Annotated[xr.Dataset, reading_netcdf],
    intervals: pd.DataFrame,
    closures: pd.DataFrame,
    surfaces: str,
    curve_files: list[str],
    fits: pd.DataFrame | None,
    flow: pd.DataFrame | None,
    rocks: dict[str, StudyRock],
    curves: dict[str, CurveSettings],
    seating_stress: float,
    wall_strength_ratio: float,
    surface_settings: SurfaceSettings,
    log: Callable[[str], object],
):
    """Draw the figures of the study itself, as PNG and PDF."""
    from studies.paper.plotting import study as plotting
    from studies.paper.plotting.flow import flow_figure
    from studies.paper.plotting.measured import Measurements

    measured = Measurements()
    if fits is not None:
        measured = Measurements(measured_curves(curves, read_text), fits)
    drawn = np.union1d(study.realization.values[: plotting.MOST_DRAWN], measured.best)
    shown = study.sel(realization=drawn.astype(int)).load()
    log(f"curves of {shown.sizes['realization']} of {study.sizes['realization']} surfaces")
    pair = read_netcdf(surfaces)
    check_settings(surfaces, pair.attrs, surface_settings)
    first = next(iter(rocks.values()))

    def closure(seating: float | None, measured: Measurements = Measurements()):
        return plotting.closure_figure(shown, rocks, seating, wall_strength_ratio, measured)

    figures = {
        "fig_3_equivalent_stress": plotting.equivalent_stress(),
        "fig_5_closure": closure(None),
        "closure_since_seating": closure(seating_stress, measured),
        "wall_pair": plotting.wall_pair_figure(
            pair.upper.values[0],
            pair.lower.values[0],
            pair.attrs["spacing_m"],
            f"{first.title}, {roughness_title(first)}, realisation 0",
        ),
    }
    if flow is not None:
        figures["hydraulic_aperture"] = flow_figure(flow, rocks, seating_stress)
    if any(rock.levels for rock in rocks.values()):
        figures["table_3_intervals"] = plotting.interval_figure(intervals, rocks)
        figures["trends_max_closure"] = plotting.trend_figure(closures, shown, rocks)
    return figures


@product(listed=lambda plan: _files(["table_3_predictive"]), when=lambda plan: plan.varied)
def draw_pool_figures(
    lengths: Annotated[xr.Dataset, read_netcdf],
    paper: pd.DataFrame,
    rocks: dict[str, StudyRock],
    realizations: int,
):
    """Draw the figures of the study's pool, as PNG and PDF."""
    from studies.paper.plotting.sensitivity import predictive_figure

    return {"table_3_predictive": predictive_figure(lengths, paper, rocks, realizations)}

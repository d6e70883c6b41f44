"""Draw the figures of the study itself, as PNG and PDF."""

from pathlib import Path

import numpy as np

from jointclosure.config.plain import from_plain
from jointclosure.config.typed import StudyRock
from jointclosure.engine.settings import SurfaceSettings, check_settings
from jointclosure.jobs.job import job
from jointclosure.jobs.logbook import Logbook
from jointclosure.measured.curves import CurveSettings, measured_curves
from jointclosure.plotting import study as plotting
from jointclosure.plotting.flow import flow_figure
from jointclosure.plotting.measured import Measurements
from jointclosure.sensitivity.tables import roughness_title
from jointclosure.storage.figures import save_figures
from jointclosure.storage.netcdf import read_netcdf, reading_netcdf
from jointclosure.storage.text import read_csv, read_text


def main(inputs: dict, outputs: list[str], settings: dict, log: Logbook) -> None:
    """Write each figure to those of the outputs that bear its name."""
    measured = Measurements()
    if inputs["fits"]:
        curves = measured_curves(
            from_plain(dict[str, CurveSettings], settings["curves"]), read_text
        )
        measured = Measurements(curves, read_csv(inputs["fits"]))
    with reading_netcdf(inputs["study"]) as dataset:
        drawn = np.union1d(dataset.realization.values[: plotting.MOST_DRAWN], measured.best)
        study = dataset.sel(realization=drawn.astype(int)).load()
        log(f"curves of {study.sizes['realization']} of {dataset.sizes['realization']} surfaces")
    closures, intervals = read_csv(inputs["closures"]), read_csv(inputs["intervals"])
    surfaces = read_netcdf(inputs["surfaces"])
    expected = from_plain(SurfaceSettings, settings["surfaces"])
    check_settings(inputs["surfaces"], surfaces.attrs, expected)
    rocks = from_plain(dict[str, StudyRock], settings["rocks"])
    first = next(iter(rocks.values()))

    def closure(seating: float | None, measured: Measurements = Measurements()):
        return plotting.closure_figure(
            study, rocks, seating, settings["wall_strength_ratio"], measured
        )

    draw = {
        "fig_3_equivalent_stress": plotting.equivalent_stress,
        "fig_5_closure": lambda: closure(None),
        "closure_since_seating": lambda: closure(settings["seating_stress"], measured),
        "wall_pair": lambda: plotting.wall_pair_figure(
            surfaces.upper.values[0],
            surfaces.lower.values[0],
            surfaces.attrs["spacing_m"],
            f"{first.title}, {roughness_title(first)}, realisation 0",
        ),
        "hydraulic_aperture": lambda: flow_figure(
            read_csv(inputs["flow"]), rocks, settings["seating_stress"]
        ),
        "table_3_intervals": lambda: plotting.interval_figure(intervals, rocks),
        "trends_max_closure": lambda: plotting.trend_figure(closures, study, rocks),
    }
    figures = {name: draw[name]() for name in {Path(output).stem for output in outputs}}
    save_figures(figures, outputs, log)


if __name__ == "__main__":
    with job(snakemake) as logbook:
        main(dict(snakemake.input), list(snakemake.output.figures), dict(snakemake.params), logbook)

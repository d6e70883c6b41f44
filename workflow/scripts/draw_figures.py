"""Draw all figures of the study, as PNG and PDF."""

from pathlib import Path

from jointclosure.dataset import read_csv, read_netcdf, reading_netcdf, save_figure
from jointclosure.logbook import Logbook, logging_to
from jointclosure.plotting import study as plotting
from jointclosure.tables import roughness_title


def main(inputs: dict, outputs: list[str], settings: dict, log: Logbook) -> None:
    """Write each figure to those of the outputs that bear its name."""
    with reading_netcdf(inputs["study"]) as dataset:
        study = dataset.isel(realization=slice(plotting.MOST_DRAWN)).load()
        log(f"curves of {study.sizes['realization']} of {dataset.sizes['realization']} surfaces")
    closures = read_csv(inputs["closures"])
    surfaces = read_netcdf(inputs["surfaces"])
    rocks = settings["rocks"]
    first = next(iter(rocks.values()))
    figures = {
        "fig_3_equivalent_stress": plotting.equivalent_stress(),
        "fig_5_closure": plotting.closure_figure(
            study, rocks, 1e6 * settings["seating_stress_MPa"], settings["wall_strength_ratio"]
        ),
        "wall_pair": plotting.wall_pair_figure(
            surfaces.upper.values[0],
            surfaces.lower.values[0],
            surfaces.attrs["spacing_m"],
            f"{first['title']}, {roughness_title(first)}, realisation 0",
        ),
    }
    if inputs["intervals"]:
        intervals = read_csv(inputs["intervals"])
        figures["table_3_intervals"] = plotting.interval_figure(intervals, rocks)
        figures["trends_max_closure"] = plotting.trend_figure(closures, study, rocks)
    for output in outputs:
        save_figure(figures[Path(output).stem], output)
        log(f"drew {output}")


if __name__ == "__main__":
    with logging_to(snakemake.log[0]) as logbook:
        main(dict(snakemake.input), snakemake.output, dict(snakemake.params), logbook)

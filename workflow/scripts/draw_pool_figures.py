"""Draw the figures of the study's pool, as PNG and PDF."""

from jointclosure.config.plain import from_plain
from jointclosure.config.typed import StudyRock
from jointclosure.jobs.job import job
from jointclosure.jobs.logbook import Logbook
from jointclosure.plotting.sensitivity import along_curve_figure, predictive_figure
from jointclosure.storage.figures import save_figures
from jointclosure.storage.netcdf import read_netcdf
from jointclosure.storage.text import read_csv


def main(inputs: dict, outputs: list[str], settings: dict, log: Logbook) -> None:
    """Write each figure to those of the outputs that bear its name."""
    rocks = from_plain(dict[str, StudyRock], settings["rocks"])
    along = read_csv(inputs["along"])
    figures = {
        "table_3_predictive": predictive_figure(
            read_netcdf(inputs["drawn"]), read_csv(inputs["paper"]), rocks, settings["realizations"]
        ),
        "along_curve_elasticities": along_curve_figure(along, rocks, "elasticities"),
        "along_curve_intervals": along_curve_figure(along, rocks, "intervals"),
    }
    save_figures(figures, outputs, log)


if __name__ == "__main__":
    with job(snakemake) as logbook:
        main(dict(snakemake.input), list(snakemake.output.figures), dict(snakemake.params), logbook)

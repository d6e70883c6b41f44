"""Draw the figures of the study's pool, as PNG and PDF."""

from jointclosure.config.plain import from_plain
from jointclosure.config.typed import StudyRock
from jointclosure.jobs.job import job
from jointclosure.jobs.logbook import Logbook
from jointclosure.plotting.sensitivity import predictive_figure
from jointclosure.storage.figures import save_figures
from jointclosure.storage.netcdf import read_netcdf
from jointclosure.storage.text import read_csv


def main(inputs: dict, outputs: list[str], settings: dict, log: Logbook) -> None:
    """Write each figure to those of the outputs that bear its name."""
    rocks = from_plain(dict[str, StudyRock], settings["rocks"])
    figures = {
        "table_3_predictive": predictive_figure(
            read_netcdf(inputs["drawn"]), read_csv(inputs["paper"]), rocks, settings["realizations"]
        ),
    }
    save_figures(figures, outputs, log)


if __name__ == "__main__":
    with job(snakemake) as logbook:
        main(dict(snakemake.input), list(snakemake.output.figures), dict(snakemake.params), logbook)

"""Draw the figure of numerical stability, as PNG and PDF."""

from jointclosure.jobs import job
from jointclosure.logbook import Logbook
from jointclosure.plotting.numerics import numerics_figure
from jointclosure.storage.figures import save_figure
from jointclosure.storage.text import read_csv


def main(numerics: str, outputs: list[str], log: Logbook) -> None:
    """Write the figure to every output."""
    figure = numerics_figure(read_csv(numerics))
    for output in outputs:
        save_figure(figure, output)
        log(f"drew {output}")


if __name__ == "__main__":
    with job(snakemake) as logbook:
        main(snakemake.input[0], list(snakemake.output.figures), logbook)

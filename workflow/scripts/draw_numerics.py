"""Draw the figure of numerical stability, as PNG and PDF."""

from jointclosure.logbook import Logbook, logging_to
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
    with logging_to(snakemake.log[0]) as logbook:
        main(snakemake.input[0], snakemake.output, logbook)

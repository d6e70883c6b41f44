"""Draw the figure of numerical stability, as PNG and PDF."""

from draw_figures import save

from jointclosure.dataset import read_csv
from jointclosure.logbook import Logbook, logging_to
from jointclosure.numerics_plotting import numerics_figure


def main(numerics: str, outputs: list[str], log: Logbook) -> None:
    """Write the figure to every output."""
    figure = numerics_figure(read_csv(numerics))
    for output in outputs:
        save(figure, output)
        log(f"drew {output}")


if __name__ == "__main__":
    with logging_to(snakemake.log[0]) as logbook:
        main(snakemake.input[0], snakemake.output, logbook)

"""Draw the figure of a table: the parameter ``figure`` says which."""

from collections.abc import Callable

import pandas as pd
from matplotlib.figure import Figure

from jointclosure.jobs.job import job
from jointclosure.jobs.logbook import Logbook
from jointclosure.plotting.numerics import numerics_figure
from jointclosure.storage.figures import save_figure
from jointclosure.storage.text import read_csv

FIGURES: dict[str, Callable[[pd.DataFrame], Figure]] = {
    "numerics": numerics_figure,
}


def main(table: str, figure: str, outputs: list[str], log: Logbook) -> None:
    """Write the figure to every output."""
    drawn = FIGURES[figure](read_csv(table))
    for output in outputs:
        save_figure(drawn, output)
        log(f"drew {output}")


if __name__ == "__main__":
    with job(snakemake) as logbook:
        main(snakemake.input[0], snakemake.params.figure, list(snakemake.output.figures), logbook)

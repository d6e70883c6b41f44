"""Summarise the errors of selected effects at random conditions."""

import pandas as pd

from jointclosure.storage.figures import save_figures
from jointclosure.storage.text import read_csv, write_csv
from studies.effects.figures import choice_figure, region_figure
from studies.effects.validation import validation_summary
from studies.frame.jobs.job import job
from studies.frame.jobs.logbook import Logbook

FIGURES = {"effects_auto": choice_figure, "effects_regions": region_figure}


def main(inputs: list[str], outputs, log: Logbook) -> None:
    """Write all scenes, their summary, and the figures."""
    table = pd.concat(map(read_csv, inputs), ignore_index=True)
    write_csv(table, outputs.scenes)
    summary = validation_summary(table)
    write_csv(summary, outputs.summary)
    log(summary.round(2).to_string(index=False))
    save_figures({name: draw(table) for name, draw in FIGURES.items()}, outputs.figures, log)


if __name__ == "__main__":
    with job(snakemake) as logbook:
        main(list(snakemake.input.scenes), snakemake.output, logbook)

"""Draw how likely Table 3 is in each reading, and what tells readings apart."""

from pathlib import Path

from jointclosure.jobs.job import job
from jointclosure.jobs.logbook import Logbook
from jointclosure.plotting.readings import likelihoods, sensitivities
from jointclosure.storage.figures import save_figure
from jointclosure.storage.text import read_csv


def main(inputs: dict, draws: int, outputs: list[str], log: Logbook) -> None:
    """Write the figure that each output's name asks for."""
    table, implied = read_csv(inputs["table"]), read_csv(inputs["implied"])
    paper = read_csv(inputs["paper"])
    for output in outputs:
        if Path(output).stem == "readings_likelihood":
            figure = likelihoods(table, implied)
        else:
            figure = sensitivities(table, paper, draws)
        save_figure(figure, output)
        log(f"drew {output}")


if __name__ == "__main__":
    with job(snakemake) as logbook:
        main(dict(snakemake.input), snakemake.params.draws, list(snakemake.output.figures), logbook)

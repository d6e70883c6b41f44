"""Draw how likely Table 3 is in each reading, and what tells readings apart."""

from pathlib import Path

from jointclosure.dataset import read_csv, save_figure
from jointclosure.logbook import Logbook, logging_to
from jointclosure.plotting.readings import likelihoods, sensitivities


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
    with logging_to(snakemake.log[0]) as logbook:
        main(dict(snakemake.input), snakemake.params.draws, list(snakemake.output), logbook)

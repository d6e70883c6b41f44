"""Draw what matters when properties and open choices vary together."""

from pathlib import Path

from jointclosure.jobs.job import job
from jointclosure.jobs.logbook import Logbook
from jointclosure.plotting.global_sensitivity import conclusions, convergence, indices
from jointclosure.storage.figures import save_figure
from jointclosure.storage.text import read_csv

DRAWN = {
    "indices": lambda tables, titles: indices(tables["indices"], titles),
    "convergence": lambda tables, titles: convergence(tables["indices"], titles),
    "conclusions": lambda tables, titles: conclusions(tables["conclusions"], titles),
}


def main(files: list[str], titles: dict, outputs: list[str], log: Logbook) -> None:
    """Write the figure that each output's name asks for."""
    tables = {Path(file).stem.removeprefix("global_"): read_csv(file) for file in files}
    for output in outputs:
        save_figure(DRAWN[Path(output).stem.removeprefix("global_")](tables, titles), output)
        log(f"drew {output}")


if __name__ == "__main__":
    with job(snakemake) as logbook:
        main(
            list(snakemake.input.tables),
            dict(snakemake.params.titles),
            list(snakemake.output.figures),
            logbook,
        )

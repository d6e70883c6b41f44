"""Draw error against time, variant by variant, and where the error comes from."""

from pathlib import Path

from jointclosure.jobs import job
from jointclosure.logbook import Logbook
from jointclosure.plotting.accuracy import SCENE_TITLES, error_sources, work_precision
from jointclosure.storage.figures import save_figure
from jointclosure.storage.text import read_csv


def main(inputs: dict, outputs: list[str], log: Logbook) -> None:
    """Write the figure that each output's name asks for."""
    costs, sources = read_csv(inputs["costs"]), read_csv(inputs["sources"])
    for output in outputs:
        name = Path(output).stem.removeprefix("accuracy_")
        if name == "sources":
            with_rules = sources.groupby("scene").source.transform(
                lambda of_scene: of_scene.str.startswith("surface rule").any()
            )
            shown = sources[with_rules] if with_rules.any() else sources
            figure = error_sources(shown, "Where the error of the configured setting comes from")
        else:
            title = f"What accuracy costs: {SCENE_TITLES.get(name, name.replace('_', ' '))}"
            figure = work_precision(
                costs[costs.scene == name], title, "as configured (the paper's)"
            )
        save_figure(figure, output)
        log(f"drew {output}")


if __name__ == "__main__":
    with job(snakemake) as logbook:
        main(dict(snakemake.input), list(snakemake.output.figures), logbook)

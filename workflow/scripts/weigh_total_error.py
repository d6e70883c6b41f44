"""Compute and draw the total error of all methods over their core-minutes."""

from jointclosure.storage.figures import save_figure
from jointclosure.storage.logs import Logbook
from jointclosure.storage.text import read_csv, write_csv
from studies.accuracy.figures import total_error_figure
from studies.accuracy.total import (
    Diagram,
    method_table,
    point_table,
    split_table,
    time_cheap,
)
from studies.frame.jobs.job import job


def main(inputs: dict, settings: dict, outputs, log: Logbook) -> None:
    """Write methods, points and splits, and the figure to each of its outputs."""
    design, joint = settings["design"], settings["joint"]
    total = design["total"]
    cheap = time_cheap(joint)
    log(f"FFT pairs: {cheap}")
    diagram = Diagram(total, design["parameter"], joint.levels, settings["measured"])
    tables = (read_csv(inputs[name]) for name in ("costs", "variance"))
    methods = method_table(diagram, *tables, cheap)
    points = point_table(methods)
    splits = split_table(points, total["budgets_min"])
    for table, name in ((methods, "methods"), (points, "points"), (splits, "splits")):
        write_csv(table, outputs[name])
    log(splits.to_string(index=False))
    figure = total_error_figure(points)
    for output in outputs["figures"]:
        save_figure(figure, output)


if __name__ == "__main__":
    with job(snakemake) as logbook:
        main(dict(snakemake.input), dict(snakemake.params), dict(snakemake.output), logbook)

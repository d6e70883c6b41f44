"""Put the groups of hard cases together: one table, one page of pictures."""

import pandas as pd

from jointclosure.jobs.job import job
from jointclosure.jobs.logbook import Logbook
from jointclosure.plotting.hard_cases import hard_case_page
from jointclosure.storage.figures import save_figure
from jointclosure.storage.text import read_csv, write_csv
from jointclosure.verification.formulas import formula_rows

INPUTS = ("tables", "curves", "formulas", "loads")


def main(inputs: dict, order: list[str], outputs: dict, log: Logbook) -> None:
    """Write the table in the order of the configuration, and the page."""
    table = pd.concat([read_csv(path) for path in inputs["tables"]])
    table = table.set_index("name").loc[order].reset_index()
    curves = pd.concat([read_csv(path) for path in inputs["curves"]])
    formulas = formula_rows(*(read_csv(inputs[name][0]) for name in ("formulas", "loads")))
    whole = pd.concat([table, pd.DataFrame(formulas)], ignore_index=True)
    write_csv(whole, outputs["table"])
    page = hard_case_page(table, curves)
    for path in outputs["figures"]:
        save_figure(page, path)
    log(f"{int(whole.holds.sum())} of {len(whole)} hold")


def _list(paths) -> list[str]:
    return [paths] if isinstance(paths, str) else list(paths)


if __name__ == "__main__":
    with job(snakemake) as logbook:
        main(
            {name: _list(snakemake.input[name]) for name in INPUTS},
            snakemake.params.order,
            {"table": snakemake.output.table, "figures": list(snakemake.output.figures)},
            logbook,
        )

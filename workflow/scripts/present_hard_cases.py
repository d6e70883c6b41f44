"""Join the groups of hard cases in one table with their errors; draw cases and errors."""

from pathlib import Path

import pandas as pd

from jointclosure.engine.assess import FEATURES
from jointclosure.storage.files import read_csv, save_figure, write_csv
from jointclosure.storage.logs import Logbook
from jointclosure.storage.provenance import commit, processor, versions_of
from studies.frame.jobs import job, listed
from studies.verification.figures import hard_case_page, numerics_figure
from studies.verification.printed import formula_rows
from studies.verification.requirements import error_table

INPUTS = ("tables", "curves", "formulas", "loads")


def main(inputs: dict, order: list[str], outputs: dict, log: Logbook) -> None:
    """Write the table in the order of the configuration, and the figures."""
    table = pd.concat([read_csv(path) for path in inputs["tables"]])
    table = table.set_index("name").loc[order].reset_index()
    curves = pd.concat([read_csv(path) for path in inputs["curves"]])
    formulas, loads = (read_csv(inputs[name][0]) for name in ("formulas", "loads"))
    rows = pd.DataFrame(formula_rows(formulas, loads))
    whole = pd.concat([table, rows], ignore_index=True)
    write_csv(whole, outputs["table"])
    versions = versions_of("numpy", "scipy", "numba")
    origin = {
        "processor": processor(),
        "versions": " ".join(f"{package} {version}" for package, version in versions.items()),
        "commit": commit(),
    }
    write_csv(error_table(table, origin), outputs["errors"])
    features = table[["name", *FEATURES]].dropna(subset="contacts_at_max")
    write_csv(features, outputs["features"], figures=4)
    figures = {"hard_cases": hard_case_page(table, curves), "numerics": numerics_figure(formulas)}
    for path in outputs["figures"]:
        save_figure(figures[Path(path).stem], path)
    log(f"{int(whole.holds.sum())} of {len(whole)} hold")


if __name__ == "__main__":
    with job(snakemake) as logbook:
        main(
            {name: listed(snakemake.input[name]) for name in INPUTS},
            snakemake.params.order,
            {
                "table": snakemake.output.table,
                "errors": snakemake.output.errors,
                "features": snakemake.output.features,
                "figures": list(snakemake.output.figures),
            },
            logbook,
        )

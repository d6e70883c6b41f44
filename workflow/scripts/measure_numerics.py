"""Measure the errors of the paper's formulas and sweep, of ours, and of elastic joints."""

import numpy as np
import pandas as pd

from jointclosure.storage.files import write_csv
from jointclosure.storage.logs import Logbook
from studies.frame.jobs import job
from studies.verification import printed, sweeps
from studies.verification.analytic import analytic_table


def main(outputs: dict[str, str], log: Logbook) -> None:
    """Write the errors over their ranges, both sweeps over loads, and exact solutions' errors."""
    half_ranges = np.logspace(-9, -0.5, 52)
    table = pd.concat(
        [
            printed.cubic_errors(np.logspace(-12, 12, 97)),
            printed.far_field_errors(np.logspace(0, 9, 109)),
            *(printed.quartic_errors(half_ranges, base) for base in (78e9, 1e-9)),
            sweeps.convergence_histories(),
        ]
    )
    tables = {"numerics": table, "loads": sweeps.load_table(), "analytic": analytic_table()}
    for name, rows in tables.items():
        write_csv(rows, outputs[name])
        log(f"wrote {outputs[name]}: {len(rows)} rows")


if __name__ == "__main__":
    with job(snakemake) as logbook:
        main(dict(snakemake.output), logbook)

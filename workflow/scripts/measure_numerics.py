"""Measure the errors of the paper's formulas and sweep, and of ours."""

import numpy as np
import pandas as pd

from jointclosure.jobs.job import job
from jointclosure.jobs.logbook import Logbook
from jointclosure.storage.text import write_csv
from jointclosure.verification import printed, sweeps


def main(numerics: str, loads: str, log: Logbook) -> None:
    """Write the errors over their ranges, and both sweeps over loads."""
    half_ranges = np.logspace(-9, -0.5, 52)
    table = pd.concat(
        [
            printed.cubic_errors(np.logspace(-12, 12, 97)),
            printed.far_field_errors(np.logspace(0, 9, 109)),
            *(printed.quartic_errors(half_ranges, base) for base in (78e9, 1e-9)),
            sweeps.convergence_histories(),
        ]
    )
    write_csv(table, numerics)
    log(f"wrote {numerics}: {len(table)} errors")
    write_csv(sweeps.load_table(), loads)
    log(f"wrote {loads}")


if __name__ == "__main__":
    with job(snakemake) as logbook:
        main(snakemake.output.numerics, snakemake.output.loads, logbook)

"""Close and judge the hard cases of a group."""

import faulthandler
import sys

import pandas as pd

from jointclosure.storage.files import write_csv
from jointclosure.storage.logs import Logbook
from studies.frame.jobs import job
from studies.verification.hard_cases import (
    curve_of,
    failed_requirements,
    features_of_case,
    row_of,
    run_case,
)

PATIENCE = 10.0
"""Multiple of its budget after which a case counts as endless: the job ends with a traceback."""


def main(cases: dict[str, dict], group: str, outputs: dict, log: Logbook) -> None:
    """Write the rows and the closure curves of the group's cases."""
    rows, curves = [], []
    for name, case in cases.items():
        if case["group"] != group:
            continue
        faulthandler.dump_traceback_later(PATIENCE * case["seconds"], exit=True, file=sys.stderr)
        outcome = run_case(case)
        failed = failed_requirements(outcome, cases)
        faulthandler.cancel_dump_traceback_later()
        rows.append(row_of(outcome, failed) | features_of_case(case))
        curves.append(curve_of(outcome))
        log(f"{name}: {outcome.status}, {outcome.seconds:.2f} s, {'; '.join(failed) or 'holds'}")
    write_csv(pd.DataFrame(rows), outputs["table"])
    write_csv(pd.concat(curves), outputs["curves"])


if __name__ == "__main__":
    with job(snakemake) as logbook:
        main(
            snakemake.params.cases,
            snakemake.wildcards.hard_group,
            dict(snakemake.output),
            logbook,
        )

"""Check what must hold for every joint; `require_checks` makes an error of a failed check."""

import json

import pandas as pd

from jointclosure.storage.files import read_text, write_csv
from jointclosure.storage.logs import logging_to
from studies.frame.checked_files import read_checked
from studies.frame.datasets import CURVES
from studies.paper.checks import REMARKED, check_results

if __name__ == "__main__":
    with logging_to(snakemake.log[0]) as log:
        planned = json.loads(read_text(snakemake.input.plan)) if snakemake.input.plan else {}
        parts = []
        ensembles = snakemake.params.ensembles.items()
        for file, (ensemble, stated) in zip(snakemake.input.datasets, ensembles, strict=True):
            key, realizations, numerics = stated
            dataset = read_checked(file, key, without=CURVES)
            count = planned.get(ensemble, realizations)
            parts.append(check_results(dataset, numerics, count, ensemble))
        checks = pd.concat(parts)
        for row in checks.itertuples():
            verdict = "passed" if row.passed else "FAILED"
            line = f"{row.ensemble}: {row.check}: {row.found}"
            log(f"{verdict}: {line} ({row.required})")
            if row.check.startswith(REMARKED) and not row.found.startswith("0 of"):
                log.show(line)
        write_csv(checks, snakemake.output[0])

"""Check the results; `require_checks` makes an error of a failed check."""

import pandas as pd

from jointclosure.config.plain import from_plain
from jointclosure.ensemble.aggregation import CURVES
from jointclosure.ensemble.checks import check_results
from jointclosure.jobs.job import job
from jointclosure.jobs.logbook import Logbook
from jointclosure.parameters import Numerics
from jointclosure.storage.netcdf import read_netcdf
from jointclosure.storage.text import write_csv


def main(ensembles: list[str], settings: dict, output: str, log: Logbook) -> None:
    """Write the table of checks of all ensembles, those that failed too."""
    numerics = from_plain(Numerics, settings["numerics"])
    tables = [
        check_results(read_netcdf(file, without=CURVES), numerics, realizations, name)
        for file, (name, realizations) in zip(
            ensembles, settings["realizations"].items(), strict=True
        )
    ]
    checks = pd.concat(tables)
    for row in checks.itertuples():
        verdict = "passed" if row.passed else "FAILED"
        log(f"{verdict}: {row.ensemble}: {row.check}: {row.found} ({row.required})")
    write_csv(checks, output)


if __name__ == "__main__":
    with job(snakemake) as logbook:
        main(list(snakemake.input.ensembles), dict(snakemake.params), snakemake.output[0], logbook)

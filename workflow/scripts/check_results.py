"""Check the results. What fails is in the table; `require_checks` makes it an error."""

from jointclosure.config.plain import from_plain
from jointclosure.ensemble.aggregation import CURVES
from jointclosure.ensemble.checks import check_results
from jointclosure.jobs import job
from jointclosure.logbook import Logbook
from jointclosure.parameters import Numerics
from jointclosure.storage.netcdf import read_netcdf
from jointclosure.storage.text import write_csv


def main(study: str, settings: dict, output: str, log: Logbook) -> None:
    """Write the table of checks, those that failed too."""
    checks = check_results(
        read_netcdf(study, without=CURVES),
        from_plain(Numerics, settings["numerics"]),
        settings["realizations"],
    )
    for row in checks.itertuples():
        log(f"{'passed' if row.passed else 'FAILED'}: {row.check}: {row.found} ({row.required})")
    write_csv(checks, output)


if __name__ == "__main__":
    with job(snakemake) as logbook:
        main(snakemake.input[0], dict(snakemake.params), snakemake.output[0], logbook)

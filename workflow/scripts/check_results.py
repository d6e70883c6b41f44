"""Check the results; what must hold and does not is an error."""

from jointclosure.config.configuration import numerics_of
from jointclosure.ensemble.aggregation import CURVES
from jointclosure.ensemble.checks import check_results
from jointclosure.logbook import Logbook, logging_to
from jointclosure.storage.netcdf import read_netcdf
from jointclosure.storage.text import write_csv


def main(study: str, settings: dict, output: str, log: Logbook) -> None:
    """Write the table of checks, or raise with those that failed."""
    checks = check_results(
        read_netcdf(study, without=CURVES),
        numerics_of(settings),
        settings["realizations"],
    )
    for row in checks.itertuples():
        log(f"{'passed' if row.passed else 'FAILED'}: {row.check}: {row.found} ({row.required})")
    failed = checks[~checks.passed]
    if len(failed):
        raise SystemExit(
            "results fail their checks: "
            + "; ".join(f"{r.check}: {r.found}, required {r.required}" for r in failed.itertuples())
        )
    write_csv(checks, output)


if __name__ == "__main__":
    with logging_to(snakemake.log[0]) as logbook:
        main(snakemake.input[0], dict(snakemake.params), snakemake.output[0], logbook)

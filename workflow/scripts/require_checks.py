"""Fail if a check of the results has failed."""

from jointclosure.jobs.job import job
from jointclosure.jobs.logbook import Logbook
from jointclosure.storage.text import read_csv, write_text


def main(checks: str, output: str, log: Logbook) -> None:
    """Write that all checks passed, or end with those that failed."""
    table = read_csv(checks)
    failed = table[~table.passed]
    if len(failed):
        raise SystemExit(
            f"{checks}: results fail their checks: "
            + "; ".join(
                f"{row.check} ({row.ensemble}): {row.found}, required {row.required}"
                for row in failed.itertuples()
            )
        )
    write_text(f"{len(table)} checks passed\n", output)
    log(f"{len(table)} checks passed")


if __name__ == "__main__":
    with job(snakemake) as logbook:
        main(snakemake.input[0], snakemake.output[0], logbook)

"""Hold the paper's claims against the study."""

from jointclosure.jobs import job
from jointclosure.logbook import Logbook
from jointclosure.storage.netcdf import reading_netcdf
from jointclosure.storage.text import read_csv, write_csv
from jointclosure.studies.sensitivity.claims import Evidence, judge_claims


def main(study: str, intervals: str, closures: str, output: str, log: Logbook) -> None:
    """Write each claim with the paper's figures, ours, and a verdict."""
    with reading_netcdf(study) as dataset:
        claims = judge_claims(Evidence(read_csv(intervals), read_csv(closures), dataset))
    write_csv(claims, output)
    for row in claims.itertuples():
        log(f"{row.number}: {row.claim}: {row.verdict}")


if __name__ == "__main__":
    with job(snakemake) as logbook:
        main(
            snakemake.input.study,
            snakemake.input.intervals,
            snakemake.input.closures,
            snakemake.output[0],
            logbook,
        )

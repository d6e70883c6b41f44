"""Fail if a check of the results has failed."""

from jointclosure.inputs import InputError
from jointclosure.storage.files import read_csv, write_text
from jointclosure.storage.logs import logging_to
from studies.paper.requirements import REPORTED

if __name__ == "__main__":
    with logging_to(snakemake.log[0]):
        table = read_csv(snakemake.input[0])
        failed = [
            f"{row.check} ({row.ensemble}): {row.found}, required {row.required}"
            for row in table[~table.passed].itertuples()
        ]
        if failed:
            raise InputError(
                f"{snakemake.input[0]}: results fail their checks: {'; '.join(failed)}"
            )
        limited = int((table.required != REPORTED).sum())
        write_text(f"{limited} checks that have a limit passed\n", snakemake.output[0])

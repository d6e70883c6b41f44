"""Fail if a hard case does not hold."""

from jointclosure.inputs import InputError
from jointclosure.storage.files import read_csv, write_text
from jointclosure.storage.logs import logging_to

if __name__ == "__main__":
    with logging_to(snakemake.log[0]) as log:
        table = read_csv(snakemake.input[0])
        for row in table[table.within_budget.eq(False)].itertuples():
            log.show(f"{row.name} took {row.seconds} s of {row.budget_s} s; no rule forbids this")
        count = f"{int(table.holds.sum())} of {len(table)} hard cases hold"
        failed = [f"{row.name}: {row.failed}" for row in table[~table.holds].itertuples()]
        if failed:
            raise InputError(f"{count}; {'; '.join(failed)}")
        log.show(count)
        write_text(f"{count}\n", snakemake.output[0])

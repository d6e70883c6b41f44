"""Tabulate the evidence for each conclusion of the paper."""

from jointclosure.storage.files import read_csv, write_csv
from jointclosure.storage.logs import logging_to
from studies.paper.conclusions import conclusion_table

if __name__ == "__main__":
    with logging_to(snakemake.log[0]) as log:
        read, tables = snakemake.input, {}
        for name in ("jrc_range", "readings", "choices", "margins"):
            files = read.get(name)
            tables[name] = (
                read_csv(files if isinstance(files, str) else files[0]) if files else None
            )
            if not files:
                log(f"{name}: of the paper's study only; the columns are empty")
        write_csv(conclusion_table(read_csv(read.claims), **tables), snakemake.output[0])

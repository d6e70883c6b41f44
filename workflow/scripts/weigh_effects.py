"""Weigh what each effect adds against what it costs."""

from jointclosure.logbook import Logbook, logging_to
from jointclosure.storage.netcdf import read_netcdf
from jointclosure.storage.text import write_csv
from jointclosure.studies.effects.ablation import effect_table


def main(inputs: list[str], runs: list[list[str]], output: str, log: Logbook) -> None:
    """Write the table of effects."""
    datasets = map(read_netcdf, inputs)
    table = effect_table(dict(zip(map(tuple, runs), datasets, strict=True)))
    write_csv(table, output)
    log(f"{len(table)} rows")


if __name__ == "__main__":
    with logging_to(snakemake.log[0]) as logbook:
        main(snakemake.input, snakemake.params.runs, snakemake.output[0], logbook)

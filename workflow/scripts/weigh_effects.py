"""Weigh what each effect adds against what it costs."""

from jointclosure.jobs import job
from jointclosure.logbook import Logbook
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
    with job(snakemake) as logbook:
        main(list(snakemake.input.runs), snakemake.params.runs, snakemake.output[0], logbook)

"""Rank the readings that entered a round by the likelihood of Table 3, and say which are kept."""

from jointclosure.config.plain import from_plain
from jointclosure.experiments.readings.design import Design, entering, files_of
from jointclosure.experiments.readings.likelihood import question_of
from jointclosure.experiments.readings.rounds import blocks_of, round_table
from jointclosure.jobs.job import job
from jointclosure.jobs.logbook import Logbook
from jointclosure.storage.netcdf import read_netcdf
from jointclosure.storage.text import read_csv, write_csv


def main(settings: dict, inputs: dict, output: str, log: Logbook) -> None:
    """Write the ranking of a round; it is empty where no reading entered."""
    design = from_plain(Design, settings["design"])
    number = settings["number"]
    judged = read_csv(inputs["before"][0]) if inputs["before"] else None
    readings = entering(design, settings["configuration"], number, judged)
    table = round_table(
        design,
        number,
        readings,
        blocks_of(files_of(design, settings["folder"], number, readings), read_netcdf),
        question_of(settings["question"], read_csv(inputs["paper"])),
    )
    write_csv(table, output)
    for row in table.itertuples():
        log(f"{row.reading}: {row.log_likelihood:.1f}, {'kept' if row.kept else 'dropped'}")


if __name__ == "__main__":
    with job(snakemake) as logbook:
        main(dict(snakemake.params), dict(snakemake.input), snakemake.output[0], logbook)

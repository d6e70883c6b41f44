"""Put all rounds of a study of readings together: one row for each reading."""

from jointclosure.config.plain import from_plain
from jointclosure.experiments.readings.design import Design, files_of
from jointclosure.experiments.readings.likelihood import question_of
from jointclosure.experiments.readings.rounds import blocks_of
from jointclosure.experiments.readings.table import implied_table, readings_markdown, readings_table
from jointclosure.jobs.job import job
from jointclosure.jobs.logbook import Logbook
from jointclosure.storage.netcdf import read_netcdf
from jointclosure.storage.text import read_csv, write_csv, write_text


def main(settings: dict, inputs: dict, outputs: dict, log: Logbook) -> None:
    """Write the table of readings as CSV and Markdown, and the scatter that Table 3 implies."""
    design = from_plain(Design, settings["design"])
    ranked = [read_csv(file) for file in settings["rankings"]]
    files = {
        each
        for number, table in enumerate(ranked)
        for each in files_of(design, settings["folder"], number, table.reading.tolist())
    }
    blocks = blocks_of(sorted(files), read_netcdf)
    question = question_of(settings["question"], read_csv(inputs["paper"]))
    table = readings_table(design, ranked, blocks, question, 1.0 - question.design.significance)
    implied = implied_table(design, ranked, blocks, question)
    write_csv(table, outputs["table"])
    write_csv(implied, outputs["implied"])
    write_text(readings_markdown(table, implied), outputs["markdown"])
    log(f"{len(table)} readings")


if __name__ == "__main__":
    with job(snakemake) as logbook:
        main(dict(snakemake.params), dict(snakemake.input), dict(snakemake.output), logbook)

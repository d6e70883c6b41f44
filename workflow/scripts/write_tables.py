"""Write Tables 1 to 3 in the paper's layout."""

from jointclosure.jobs import job
from jointclosure.logbook import Logbook
from jointclosure.storage.text import read_csv, write_csv, write_text
from jointclosure.tables import case_table, rock_table, table_3_latex, table_3_markdown


def main(intervals: str, settings: dict, outputs: dict, log: Logbook) -> None:
    """Write the tables of rocks and cases, and Table 3 as LaTeX and Markdown."""
    configuration = {"study": settings["study"], "rocks": settings["rocks"]}
    titles = {name: rock["title"] for name, rock in settings["rocks"].items()}
    table = read_csv(intervals)
    write_csv(rock_table(configuration), outputs["rocks"])
    write_csv(case_table(configuration), outputs["cases"])
    write_text(table_3_latex(table, titles), outputs["latex"])
    write_text(table_3_markdown(table, titles), outputs["markdown"])
    log(f"wrote {', '.join(outputs.values())}")


if __name__ == "__main__":
    with job(snakemake) as logbook:
        main(snakemake.input[0], dict(snakemake.params), dict(snakemake.output), logbook)

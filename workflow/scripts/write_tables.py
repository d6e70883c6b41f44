"""Write Tables 1 to 3 in the paper's layout."""

from jointclosure.config.plain import from_plain
from jointclosure.config.typed import StudyRock
from jointclosure.jobs.job import job
from jointclosure.jobs.logbook import Logbook
from jointclosure.sensitivity.tables import case_table, rock_table, table_3_latex, table_3_markdown
from jointclosure.storage.text import read_csv, write_csv, write_text


def main(inputs: dict, rocks: dict[str, StudyRock], outputs: dict, log: Logbook) -> None:
    """Write the tables of rocks and cases, and Table 3 as LaTeX and Markdown."""
    titles = {name: rock.title for name, rock in rocks.items()}
    table, closures = read_csv(inputs["intervals"]), read_csv(inputs["closures"])
    write_csv(rock_table(rocks, closures), outputs["rocks"])
    write_csv(case_table(rocks, closures), outputs["cases"])
    write_text(table_3_latex(table, titles), outputs["latex"])
    elasticities = read_csv(inputs["elasticities"]) if inputs["elasticities"] else None
    write_text(table_3_markdown(table, titles, elasticities), outputs["markdown"])
    log(f"wrote {', '.join(outputs.values())}")


if __name__ == "__main__":
    with job(snakemake) as logbook:
        rocks = from_plain(dict[str, StudyRock], snakemake.params.rocks)
        main(dict(snakemake.input), rocks, dict(snakemake.output), logbook)

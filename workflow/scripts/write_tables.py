"""Write Tables 1 to 3 in the paper's layout."""

from jointclosure.storage.files import read_csv, write_csv, write_text
from jointclosure.storage.logs import logging_to
from studies.paper.tables_1_to_3 import case_table, rock_table, table_3_markdown

if __name__ == "__main__":
    with logging_to(snakemake.log[0]):
        read, output, rocks = snakemake.input, snakemake.output, snakemake.params.rocks
        closures, intervals = read_csv(read.closures), read_csv(read.intervals)
        elasticities = read_csv(read.elasticities) if read.elasticities else None
        titles = {name: rock.title for name, rock in rocks.items()}
        write_csv(rock_table(rocks, closures), output.rocks)
        write_csv(case_table(rocks, closures), output.cases)
        write_text(table_3_markdown(intervals, titles, elasticities), output.intervals)

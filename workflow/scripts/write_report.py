"""Write the report as one page without further files."""

from pathlib import Path

from studies.commands.report import write_report
from studies.frame.jobs import job

if __name__ == "__main__":
    with job(snakemake) as logbook:
        output = Path(snakemake.output[0])
        size = write_report(output.parent, output)
        logbook(f"wrote {output}: {size / 1e6:.1f} MB")

"""Compare the selected effects with all effects at random conditions."""

from jointclosure.inputs.plain import from_plain
from jointclosure.storage.text import write_csv
from studies.effects.validation import ValidationSettings, validate
from studies.frame.jobs.job import job
from studies.frame.jobs.logbook import Logbook


def main(settings: ValidationSettings, number: int, output: str, log: Logbook) -> None:
    """Write a row for each tolerance."""
    write_csv(validate(settings, number, log), output)
    log(f"wrote {output}")


if __name__ == "__main__":
    with job(snakemake) as logbook:
        main(
            from_plain(ValidationSettings, snakemake.params.settings),
            int(snakemake.wildcards.number),
            snakemake.output[0],
            logbook,
        )

"""Write the report: one page that holds all that it shows."""

from pathlib import Path

from jointclosure import Effects, Numerics
from jointclosure.dataset import read_benchmarks, read_csv, read_netcdf, write_text
from jointclosure.logbook import Logbook, logging_to
from jointclosure.parameters import to_si
from jointclosure.report.captions import read_caption
from jointclosure.report.content import Material, content
from jointclosure.report.page import Picture, render
from jointclosure.study.checks import check_results
from jointclosure.study.configuration import read_schema


def pictures(figures: list[str], captions: list[str], configuration: dict) -> list[Picture]:
    """Figures with their captions, which bear their names."""
    texts = {Path(path).stem: Path(path).read_text(encoding="utf-8") for path in captions}
    return [
        Picture(
            Path(path).stem,
            Path(path).read_bytes(),
            read_caption(texts[Path(path).stem], configuration),
        )
        for path in figures
    ]


def main(inputs: dict, settings: dict, output: str, log: Logbook) -> None:
    """Put the study's results, figures and job times into one page."""
    study, configuration = read_netcdf(inputs["study"]), settings["configuration"]
    material = Material(
        study=study,
        intervals=read_csv(inputs["intervals"]),
        closures=read_csv(inputs["closures"]),
        claims=read_csv(inputs["claims"]),
        # made again rather than read: where a check fails its table is not written
        checks=check_results(
            study,
            Effects(**configuration["effects"]),
            Numerics(**to_si(configuration["numerics"])),
            configuration["study"]["realizations"],
        ),
        paper=read_csv(inputs["paper"]),
        default=read_schema(inputs["default"]),
        schema=read_schema(inputs["schema"]),
        pictures=pictures(inputs["figures"], inputs["captions"], configuration),
        benchmarks=read_benchmarks(settings["benchmarks"]),
        accuracy=read_csv(inputs["accuracy"][0]) if inputs["accuracy"] else None,
    )
    page = render(content(material))
    write_text(page, output)
    log(f"wrote {output}: {len(page.encode()) / 1e6:.1f} MB")


if __name__ == "__main__":
    with logging_to(snakemake.log[0]) as logbook:
        main(dict(snakemake.input), dict(snakemake.params), snakemake.output[0], logbook)

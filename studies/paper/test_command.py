"""`python -m studies report`: from the files of a finished study to the file of its page."""

import pandas as pd
import pytest

from jointclosure.storage.netcdf import write_netcdf
from jointclosure.storage.text import write_csv
from studies import __main__ as cli
from studies.frame.jobs.seals import write_seal
from studies.paper.report.content import content
from studies.paper.report.page import render

TABLES = {
    "closures": "max_closure",
    "intervals": "table_3_indifference",
    "claims": "claims",
    "margins": "claim_margins",
    "checks": "checks",
    "predictive": "table_3_predictive",
    "joint": "table_3_joint_tests",
    "elasticities": "elasticities",
}


def finished(material, pictures, folder):
    """A made-up study as a run leaves it."""
    for name in ("tables", "figures", "seals", "benchmarks/close_surfaces"):
        (folder / name).mkdir(parents=True)
    write_netcdf(material.study, folder / "study.nc")
    write_seal(folder / "seals/aggregate.json", [folder / "study.nc"], {}, [])
    for part, name in TABLES.items():
        table = folder / f"tables/{name}.csv"
        if (frame := getattr(material, part)) is not None:
            write_csv(frame, table)
            write_seal(folder / f"seals/{name}.json", [table], {}, [])
    stated = folder / "tables/configuration.json"
    stated.write_text(material.study.attrs["configuration"])
    write_seal(folder / "seals/state_configuration.json", [stated], {}, [])
    figures = [folder / f"figures/{picture.name}.png" for picture in pictures]
    for figure, picture in zip(figures, pictures, strict=True):
        figure.write_bytes(picture.png)
    write_seal(folder / "seals/draw_figures.json", figures, {}, [])
    for job in material.benchmarks.itertuples():
        rss = "-" if pd.isna(job.max_rss) else job.max_rss
        (folder / f"benchmarks/close_surfaces/{job.job}.tsv").write_text(
            f"s\tmax_rss\n{job.s}\t{rss}\n"
        )
    return folder


@pytest.fixture
def folder(material, pictures, tmp_path):
    return finished(material, pictures, tmp_path / "made_up")


def test_the_files_give_the_page_that_their_content_gives(material, folder, capsys):
    assert cli.main(["report", str(folder)]) == 0
    assert (folder / "report.html").read_text(encoding="utf-8") == render(content(material))
    assert "report.html: " in capsys.readouterr().out


@pytest.mark.parametrize(
    "missing",
    ["study.nc", "seals/aggregate.json", "seals/checks.json", "seals/state_configuration.json"],
)
def test_a_study_that_is_not_whole_has_no_page(folder, capsys, missing):
    (folder / missing).unlink()
    assert cli.main(["report", str(folder)]) == 2
    printed = capsys.readouterr().err
    assert len(printed.splitlines()) == 1
    assert "is missing" in printed or "must exist with a seal" in printed
    assert not (folder / "report.html").exists()


def test_an_edited_table_is_in_no_page(folder, capsys):
    table = folder / "tables/claims.csv"
    table.write_text(table.read_text().replace("undecided", "stands"))
    assert cli.main(["report", str(folder)]) == 2
    assert "claims.csv: the file is not as jointclosure wrote it" in capsys.readouterr().err

"""The page of a study: its content, and `python -m studies report` from the files of a study."""

import pandas as pd
import pytest

from jointclosure.storage.netcdf import write_netcdf
from jointclosure.storage.text import write_csv
from studies import __main__ as cli
from studies.frame.config.model import model
from studies.frame.config.schema import json_schema
from studies.frame.jobs.seals import write_seal
from studies.paper.conftest import FAILED, JOINTS
from studies.paper.report.content import (
    STAYS,
    content,
    departures,
    most_sensitive,
    sensitivity_sentence,
    setting_rows,
)
from studies.paper.report.page import render


@pytest.fixture(scope="module")
def page(material):
    return content(material)


def rows_of(page, name):
    """Cells of a table by heading, by row."""
    sheet = page["sheets"][name]
    return [dict(zip(sheet.titles, row, strict=True)) for row in sheet.rows]


def test_failures_are_counted_and_named(page, material):
    cases, found = material.study.sizes["case"], page["outcome"]
    assert found["failed"] == found["flags"]["not_converged"] == cases
    assert found["flags"]["target_jumped"] == cases
    assert found["used"] == cases * (JOINTS - 1)
    failures = rows_of(page, "failures")
    assert len(failures) == cases
    case, joint, status, seed = (cell.text for cell in failures[0].values())
    assert (case, joint, status) == ("slate-base", str(FAILED), "Not converged")
    assert seed == material.study.seed.values[0, FAILED]
    row = {title: cell.text for title, cell in rows_of(page, "statuses")[0].items()}
    assert (row["Used (n)"], row["Failed"]) == (str(JOINTS - 1), "1")
    assert row["Not converged"] == row["Jumped over the target"] == "1"
    assert "Contact without compliance" not in row  # of which there is none
    assert page["failed_checks"] == 1  # not all simulations succeeded
    assert [row["Verdict"].text for row in rows_of(page, "checks")].count("FAILED") == 1


def test_the_first_screen_has_the_numbers_of_the_tables(page, material):
    row = {title: cell.key for title, cell in rows_of(page, "in-short")[0].items()}
    base = material.closures[(material.closures.parameter == "base")]
    own = base[base.rock == base.rock.iloc[0]].set_index("cycle")
    assert row["Net closure since seating, cycle 2 (mm)"] == own.max_closure_seated_net_mean_mm[2]
    stays = own.residual_closure_seated_net_mean_mm[1] / own.max_closure_seated_net_mean_mm[1]
    assert row[STAYS] == pytest.approx(100.0 * stays)
    study = material.study
    case = study.sel(case=study.case[study.parameter == "base"][0], cycle=1)
    compliance = (1e9 / case.stiffness_net).where(case.status < 16).mean()
    assert row["Net kn, cycle 1 (MPa/mm)"] == pytest.approx(1.0 / float(compliance))


def test_settings_that_differ_from_the_papers_are_found(configuration, default):
    schema = json_schema(model())
    assert departures(setting_rows(default, default, schema)) == []
    rows = setting_rows(configuration, default, schema)
    found = departures(rows)
    assert {"study.realizations", "rocks.granite.jrc"} <= set(found)
    assert not any(key.startswith("rocks.slate") for key in found)
    assert not any(key.startswith("rocks.dolerite") for key in rows.key)  # not in the study
    assert rows.meaning.str.len().min() > 5  # every key is explained


@pytest.mark.parametrize(
    ("of_slate", "of_dolerite", "error", "samples", "verdict"),
    [
        (-1.0, -1.1, 0.02, 60, "stands"),
        (-1.0, -1.1, 0.2, 4, "undecided"),
        (-1.0, -0.65, 0.005, 60, "no difference"),
        (-1.0, -0.2, 0.02, 60, "falls"),
    ],
)
def test_the_headline_says_no_more_than_its_verdict(of_slate, of_dolerite, error, samples, verdict):
    rows = [
        {"rock": rock, "parameter": name, "cycle": 2, "samples": samples, "elasticity": value}
        for rock, modulus in (("slate", of_slate), ("dolerite", of_dolerite))
        for name, value in (("youngs_modulus", modulus), ("compressive_strength", 0.6))
    ]
    table = pd.DataFrame(rows).assign(elasticity_standard_error=error)
    assert most_sensitive(table, "youngs_modulus") == verdict
    plain = "is most sensitive to Young's modulus in all 2 rocks" in sensitivity_sentence(table)
    assert plain == (verdict == "stands")


TABLES = {"closures": "max_closure", "intervals": "table_3_indifference", "claims": "claims"}
TABLES |= {"margins": "claim_margins", "checks": "checks", "predictive": "table_3_predictive"}
TABLES |= {"joint": "table_3_joint_tests", "elasticities": "elasticities"}


@pytest.fixture
def folder(material, tmp_path):
    """A made-up study as a run leaves it."""
    folder = tmp_path / "made_up"
    for name in ("tables", "figures", "seals", "benchmarks/close_surfaces"):
        (folder / name).mkdir(parents=True)

    def seal(rule, *files):
        write_seal(folder / f"seals/{rule}.json", list(files), {}, [])

    write_netcdf(material.study, folder / "study.nc")
    seal("aggregate", folder / "study.nc")
    for part, name in TABLES.items():
        write_csv(getattr(material, part), folder / f"tables/{name}.csv")
        seal(name, folder / f"tables/{name}.csv")
    (folder / "tables/configuration.json").write_text(material.study.attrs["configuration"])
    seal("state_configuration", folder / "tables/configuration.json")
    figures = [folder / f"figures/{picture.name}.png" for picture in material.pictures]
    for figure, picture in zip(figures, material.pictures, strict=True):
        figure.write_bytes(picture.png)
    seal("draw_figures", *figures)
    for job in material.benchmarks.itertuples():
        rss = "-" if pd.isna(job.max_rss) else job.max_rss
        table = folder / f"benchmarks/close_surfaces/{job.job}.tsv"
        table.write_text(f"s\tmax_rss\n{job.s}\t{rss}\n")
    return folder


def test_the_files_give_the_page_that_their_content_gives(page, folder):
    assert cli.main(["report", str(folder)]) == 0
    assert (folder / "report.html").read_text(encoding="utf-8") == render(page)


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

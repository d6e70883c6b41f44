"""Pages that are made of docs/templates: they show the stored results, and it is all there."""

import json
import re
import shutil
import sys
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

sys.path.insert(0, str(Path(__file__).parents[2] / "docs/site"))
import publish
import stored
import templates
from content import accuracy, conclusions, results, speed, validation

import jointclosure as jc
from jointclosure.joint.curves import cycle_table
from jointclosure.storage.provenance import provenance

ROOT = Path(__file__).parents[2]
ORIGIN = {"run", "commit", "stored_at", "version", "root_seed", "date", "configuration"}


def test_a_file_or_a_column_that_lacks_fails_with_its_name(tmp_path, monkeypatch):
    kept = tmp_path / "studies/mismatch/results/mismatch"
    shutil.copytree(stored.folder_of("mismatch"), kept)
    monkeypatch.setattr(stored, "STORED", tmp_path)
    monkeypatch.setattr(stored, "ROOT", tmp_path)
    table = pd.read_csv(kept / "mismatch.csv").drop(columns="hysteresis")
    table.to_csv(kept / "mismatch.csv", index=False)
    with pytest.raises(templates.PageError, match=r"mismatched\(\).*'hysteresis'"):
        templates.filled("{{ mismatch.mismatched() }}", "a.md")
    (kept / "mismatch_shifts.csv").unlink()
    with pytest.raises(templates.PageError, match=r"mismatch_shifts\.csv is not stored"):
        templates.filled("{{ mismatch.least_shift() }}", "a.md")


@pytest.mark.parametrize("template", templates.ALL, ids=lambda path: path.stem)
def test_a_committed_page_is_what_its_template_and_the_stored_results_give(template):
    page = templates.page_of(template)
    different = f"{page.name} differs: edit docs/templates/{template.name}, then make docs"
    assert page.read_text(encoding="utf-8") == templates.made(template), different


def test_what_is_stored_is_what_pages_show(monkeypatch):
    """Every stored file is read by a page, and RUNS names all that are read."""
    read = set()

    def path_of(run, table, given=stored.path_of):
        read.add((run, table))
        return given(run, table)

    monkeypatch.setattr(stored, "path_of", path_of)
    for template in templates.ALL:
        templates.made(template)
    kept = stored.RUNS.items()
    evidence = {("paper", "claims"), ("jrc_range", "jrc_range_claims")}  # of the conclusions' test
    assert read | evidence == {(run, table) for run, of in kept for table in of.tables}
    pages = [ROOT / "README.md", *sorted(templates.DOCS.rglob("*.md"))]
    shown = "".join(page.read_text(encoding="utf-8") for page in pages)
    for run, of in kept:
        names = {f"{name}.csv" for name in of.tables} | {f"{name}.png" for name in of.figures}
        folder = stored.folder_of(run)
        assert {path.name for path in folder.iterdir()} == names | {stored.ORIGIN}
        assert all(f"results/{run}/{name}.png)" in shown for name in of.figures)
        assert stored.origin(run).keys() >= ORIGIN


@pytest.fixture
def run(tmp_path, monkeypatch):
    """Results of a run, and a place where they are stored."""
    monkeypatch.setattr(stored, "ROOT", tmp_path)
    monkeypatch.setattr(stored, "STORED", tmp_path)
    (tmp_path / "studies/mismatch/results/mismatch").mkdir(parents=True)
    shutil.copytree(ROOT / "studies/mismatch/results/mismatch", tmp_path / "mismatch/tables")
    return tmp_path / "mismatch"


def test_results_that_are_not_complete_are_refused_and_what_was_stored_stays(run):
    folder = publish.publish(run, "mismatch")
    (run / "tables/mismatch_shifts.csv").unlink()
    with pytest.raises(stored.StoredError, match=r"not complete, mismatch_shifts\.csv lacks"):
        publish.publish(run, "mismatch")
    assert (folder / "mismatch_shifts.csv").is_file()


def test_results_are_stored_with_what_made_them(run, monkeypatch):
    old = run.parent / "studies/mismatch/results/mismatch/old.csv"
    old.touch()

    def untouched(study):  # the commit is that of files that were not edited yet
        assert old.exists()
        return provenance(study)

    monkeypatch.setattr(publish, "provenance", untouched)
    folder = publish.publish(run, "mismatch")
    names = {"mismatch.csv", "mismatch_shifts.csv", "mismatch.png", stored.ORIGIN}
    assert {path.name for path in folder.iterdir()} == names
    for name in names - {stored.ORIGIN}:
        assert (folder / name).read_bytes() == (run / "tables" / name).read_bytes()
    origin = json.loads((folder / stored.ORIGIN).read_text(encoding="utf-8"))
    assert origin.keys() >= ORIGIN
    assert origin["configuration"]["file"] == "studies/mismatch/mismatch.yaml"
    assert origin["configuration"]["differs"]["mismatch.tolerance"] == 0.1
    assert "numerics.solver" not in origin["configuration"]["differs"]


def test_errors_without_effects_are_summed_up_by_stress_over_strength(tmp_path):
    changes = {
        f"without_{effect}_percent": [1.0, 3.0, np.inf, 8.0]
        for effect in ("interaction", "soft_peaks", "gouge", "breakage", "substrate")
    }
    times = {name.replace("percent", "time"): 0.5 for name in changes}
    table = pd.DataFrame({"scene": range(4)} | changes).assign(**times)
    table = table.assign(compressive_strength=1e8, max_normal_stress=[2e5, 3e5, 4e5, 5e7])
    # a scene has a row for each tolerance
    pd.concat([table, table]).to_csv(tmp_path / "effects_auto.csv", index=False)
    rows = publish.regions(tmp_path).set_index("to")
    assert rows.conditions.tolist() == [0, 3, 0, 1]
    row = rows.loc[0.01]
    assert (row.interaction, row.interaction_least, row.interaction_largest) == (2.0, 1.0, 3.0)
    assert row.interaction_failed == 1
    assert rows.loc[1.0].interaction == 8.0


def test_the_readme_names_the_two_commands_that_set_up_all_they_need():
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    rules = (ROOT / "Makefile").read_text(encoding="utf-8")
    for command in ("study", "test"):
        assert f"`make {command}`" in text
        assert re.search(rf"^{command}:.*\$\(STAMP\)", rules, re.M)


def test_the_readmes_outcome_is_that_of_the_stored_study():
    """README.md is read as it is: its p of all entries and its counts of claims are typed."""
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    headline = results.headline()
    assert headline["p"] in text
    assert f"with those of the study {headline['p of the study']}" in text
    assert results.verdicts() in text
    assert f"({speed.default_study()} minutes of processor time" in text


def test_the_readme_states_the_stored_errors_of_the_papers_steps():
    """They are distances to the finest setting; README's joint is farther from it than they."""
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    assert f"the paper's steps is {accuracy.bias('paper')} % from that of the finest" in text
    assert f"by adaptive steps, in {accuracy.dearer()} times the time" in text
    assert "for the joint above the paper's steps give a quarter more net closure" in text
    walls = [ROOT / f"config/walls/joint_{wall}.npz" for wall in ("upper", "lower")]
    of_paper, adaptive = (
        cycle_table(
            jc.close(
                *walls, rock="granite", max_normal_stress=10e6, single=True, numerics=numerics
            ).history
        ).max_closure_seated_net_mm[0]
        for numerics in (jc.Numerics(), jc.Numerics(breakage="resolved"))
    )
    assert 1.2 < of_paper / adaptive < 1.3


def test_counts_of_verdicts_are_of_the_papers_claims_alone():
    rows = [line.split(" | ") for line in results.verdicts().splitlines()]
    counts = np.array([[int(cell.strip(" |")) for cell in row[1:]] for row in rows[2:]])
    assert (counts.sum(axis=0) == int(results.headline()["claims"])).all()
    assert counts[:2, 1].tolist() == [int(results.headline()[name]) for name in ("stand", "fall")]


def test_the_readme_states_the_stored_measured_share():
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    (sentence,) = re.findall(r"^.*\*\*Measured joints:.*$", text, re.M)
    assert validation.span("later_residual_share") in sentence


def test_every_claim_whose_average_differs_from_its_conclusion_has_the_reason():
    table = stored.stored("paper", "conclusions").set_index("number")
    averages = stored.stored("readings_average", "readings_average_claims").set_index("number")
    text = conclusions.differing()
    for number, row in table[table.section != "ours"].iterrows():
        known = number in averages.index
        alike = known and row.conclusion.removesuffix(" as configured") == averages.verdict[number]
        (line,) = re.findall(rf"^\| {number} \|.*$", text, re.M) or [""]
        assert bool(line) == (known and not alike)
        if line and row.verdict == averages.verdict[number]:
            assert "open choices" in line
        elif line:
            assert f"{row.verdict} as configured" in line


def test_a_margin_is_shown_with_what_its_claim_needs():
    assert conclusions.threshold("2a") == "true above 0.1, no difference within ±0.1"
    assert conclusions.threshold("5d") == "true up to 0.1"  # negated
    assert conclusions.threshold("1b") == "true above 0"  # of the distance to the bound

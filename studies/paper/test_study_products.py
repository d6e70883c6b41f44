"""Products of a study: made of what they read, and again only when that changes."""

from functools import partial
from pathlib import Path

import pandas as pd
import pytest

from studies.frame.plan import Plan
from studies.frame.products import make_files
from studies.paper.products import PRODUCTS
from tests.studied import ROOT, checked_study

COLUMNS = ["ensemble", "check", "required", "found", "passed"]
PASSED = ("cases", "least force", "not negative", "0", True)
FAILED = ("pool", "volume", "at most 1e-12", "2e-9 of it", False)
CURVE = {"rocks": {"slate": {"measured": {"file": "config/my_rock_measured.csv"}}}}


def plan(*changes: dict) -> Plan:
    return Plan(checked_study(*changes))


def settings(*changes: dict) -> dict[str, dict]:
    study = plan(*changes)
    return {name: study.settings(product) for name, product in PRODUCTS.items()}


@pytest.fixture(scope="module")
def unchanged():
    return settings()


RANDOM = {"find_indifference_intervals", "predict_table_3", "judge_claims", "measure_covariates"}
TITLED = {"write_tables", "draw_figures", "draw_pool_figures"}


@pytest.mark.parametrize(
    ("change", "made_again"),
    [
        ({"statistics": {"bootstrap_resamples": 77}}, {"find_indifference_intervals"}),
        ({"statistics": {"repetitions": 777}}, {"predict_table_3", "judge_claims"}),
        ({"statistics": {"control_variates": 777}}, {"measure_covariates"}),
        ({"output": {"wall_strength_ratio": 7.0}}, {"draw_figures"}),
        ({"numerics": {"force_tolerance": 1e-8}}, {"check_results"}),
        ({"study": {"root_seed": 77}}, RANDOM),
        ({"study": {"pool": 77}}, {"check_results"}),
        ({"rocks": {"slate": {"title": "Another slate"}}}, TITLED),
        (CURVE, TITLED | {"fit_measured"}),
        ({"choices": {"peak_modulus_ratio": 0.1}}, set()),
        ({"study": {"cycles": 3, "realizations_per_job": 7}}, set()),
    ],
    ids=lambda value: str(value) if isinstance(value, dict) else "",  # sets have no order
)
def test_settings_change_of_the_products_that_read_a_key_and_of_no_other(
    unchanged, change, made_again
):
    after = settings(change)
    changed = {name for name in PRODUCTS if after[name] != unchanged[name]}
    assert changed == made_again | {"state_configuration"}


@pytest.mark.parametrize("changes", [{}, {"flow": True} | CURVE, {"study": {"pool": None}}])
def test_files_that_products_read_are_of_the_ensembles_or_made_by_one_product(changes, monkeypatch):
    monkeypatch.chdir(ROOT)
    study = plan(changes)
    planned = [product for product in PRODUCTS.values() if product.when(study)]
    made = [study.file(name) for product in planned for name in product.files(study)]
    assert len(set(made)) == len(made)
    known = [*made, *map(study.file, ("study.nc", "pool.nc", "first_walls.nc"))]
    for product in planned:
        for paths in study.inputs(product).values():
            for path in [paths] if isinstance(paths, str) else paths:
                stored = not path.startswith("results/") and Path(path).is_file()
                assert path in known or stored


@pytest.mark.parametrize("rows", [[PASSED, FAILED], [PASSED, PASSED]])
def test_a_failed_check_ends_the_run_naming_it_and_leaves_no_note(tmp_path, rows):
    table, note = tmp_path / "checks.csv", tmp_path / "checks_passed.txt"
    pd.DataFrame(rows, columns=COLUMNS).to_csv(table, index=False)
    lines: list[str] = []
    make = partial(make_files, PRODUCTS["require_checks"].make, {"checks": str(table)}, {})
    if FAILED not in rows:
        make([str(note)], log=lines.append)
        assert note.read_text() == "2 checks passed\n"
        assert lines == [f"wrote {note}"]
        return
    with pytest.raises(SystemExit) as ended:
        make([str(note)], log=lines.append)
    assert "volume (pool): 2e-9 of it, required at most 1e-12" in str(ended.value)
    assert "least force" not in str(ended.value)
    assert not note.exists()


def test_tables_of_other_studies_are_read_by_the_study_of_their_model_only(monkeypatch):
    monkeypatch.chdir(ROOT)
    for name, expected in (("paper", 4), ("mine", 0)):
        inputs = plan({"study": {"name": name}}).inputs(PRODUCTS["conclude"])
        beside = (inputs[key] for key in ("jrc_range", "readings", "choices", "margins"))
        assert sum(map(bool, beside)) == expected

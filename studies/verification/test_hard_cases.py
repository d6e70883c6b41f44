"""Every hard case is a test (what the judging itself must notice is in test_oracle)."""

from pathlib import Path

import pytest

import jointclosure as jc
from jointclosure.assessment.hardness import HARD_CASES
from jointclosure.storage.files import read_csv
from studies.frame.yaml_files import read_plain
from studies.verification.hard_cases import (
    ERRORS,
    FLOOR,
    failed_requirements,
    features_of_case,
    grown_errors,
    merged_cases,
    run_case,
)

HERE = Path(__file__).parent
STUDY = read_plain(HERE / "hard_cases.yaml")
CASES = merged_cases(STUDY)
STORED = read_csv(HERE / "published/hard_cases/hard_case_errors.csv").set_index("name")
SLOW = {name for name, case in CASES.items() if case["slow"]}
# cases of resolved breakage that are dear, and of which that by fixed steps is quick
SLOW |= {f"{name}_resolved" for name in ("crushed_shut", "strip_1000_x_7")}
SLOW |= {f"{name}_resolved" for name in CASES if name.startswith("scene") and "gouge" not in name}


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=[pytest.mark.slow] * (name in SLOW)) for name in CASES]
)
def test_a_hard_case_holds(name):
    """Its requirements hold, and no error is more than four times that of the stored table."""
    outcome = run_case(CASES[name])
    assert failed_requirements(outcome, CASES) == []
    if outcome.judge.states:
        assert grown_errors(STORED.loc[name], outcome.judge.worst) == []


def test_the_hard_cases_of_the_library_are_the_stored_ones():
    stored = HERE / "published/hard_cases/hard_case_features.csv"
    assert HARD_CASES.read_bytes() == stored.read_bytes()
    table = read_csv(stored).set_index("name").drop(columns="hard")
    assert set(table.index) <= set(CASES)
    for name in ("saddles", "swapped_walls", "crushed_shut", "egg_box_resolved"):
        features = features_of_case(CASES[name])
        assert features == pytest.approx(table.loc[name].to_dict(), rel=1e-3, abs=1e-9)


def test_an_error_that_grows_is_named_unless_it_is_rounding():
    fields = [field for names in ERRORS.values() for field in names]
    stored = dict.fromkeys(ERRORS, 1e-11) | {"processor": "", "versions": ""}
    present = dict.fromkeys(fields, 3.9e-11)
    assert grown_errors(stored, present) == []
    grown = grown_errors(stored, present | {"residual": 4.1e-11, "load": float("nan")})
    assert [line.split()[0] for line in grown] == ["residual", "load"]
    small = stored | {"load": 0.0}
    assert grown_errors(small, present | {"load": 3.9 * FLOOR}) == []
    assert grown_errors(small, present | {"load": 4.1 * FLOOR})


def test_every_answered_case_has_stored_errors():
    answered = {name for name, case in CASES.items() if case["expect"] == "answer"}
    assert answered <= set(STORED.index) <= set(CASES)


def test_all_18_scenes_are_among_the_cases():
    assert len({name.removesuffix("_resolved") for name in CASES}) >= 40
    scenes = {tuple(c["effects"].items()) for n, c in CASES.items() if n.startswith("scene_")}
    assert len(scenes) == 18


@pytest.mark.parametrize(
    ("change", "named"),
    [
        ({"wals": {}}, "did you mean walls"),
        ({"expect": "fine"}, "expect = 'fine'"),
        ({"must": {"same_as": {"case": "none", "within": 0}}}, "compared with 'none'"),
    ],
)
def test_a_wrong_case_is_refused_by_name(change, named):
    one = {"name": "one", "group": "some", "hard": "something", "must_hold": "something"} | change
    with pytest.raises(jc.InputError, match=named):
        merged_cases(STUDY | {"cases": [*STUDY["cases"], one]})


@pytest.mark.parametrize(
    ("change", "named"),
    [
        ({"expect": "target_jumped"}, "expected target_jumped"),
        ({"must": {"closure": {"value": 1.0, "within": 0.1}}}, "expected 1.0"),
        ({"must": {"same_as": {"case": "swapped_walls", "within": 1e-3}}}, "differs from"),
        ({"must": {"nothing_breaks": False}}, "0 breakage steps"),
        ({"must": {"contact_fraction": {"least": 0.9, "most": 1.0}}}, "contact fraction"),
        ({"max_normal_stress": 1e12}, "status refused"),
    ],
)
def test_what_does_not_hold_is_named(change, named):
    failed = failed_requirements(run_case(CASES["base_elastic"] | change), CASES)
    assert any(named in line for line in failed), failed

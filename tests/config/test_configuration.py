from pathlib import Path

import pytest
import yaml

from jointclosure.config.configuration import (
    ConfigurationError,
    checked,
    choice_tolerance,
    choices_of,
    effects_of,
    end_of_stress_axis,
    numerics_of,
    read_plain,
    read_schema,
    written_out,
)
from jointclosure.config.units import to_si
from jointclosure.ensemble.cases import cases_of, wall_seed
from jointclosure.studies.accuracy import design as accuracy

ROOT = Path(__file__).parents[2]
SCHEMA = read_schema(ROOT / "workflow/schemas/config.schema.yaml")
DEFAULT = yaml.safe_load((ROOT / "config/default.yaml").read_text())


def merged(changes: dict) -> dict:
    """The default configuration with overrides, merged as Snakemake does."""
    return accuracy.merged(DEFAULT, changes)


STUDIES = sorted(set((ROOT / "config").glob("*.yaml")) - {ROOT / "config/hard_cases.yaml"})


@pytest.mark.parametrize("path", STUDIES, ids=lambda p: p.stem)
def test_every_configuration_in_the_project_is_valid(path):
    checked(merged(yaml.safe_load(path.read_text())), SCHEMA)


def test_the_stress_axis_ends_at_the_largest_maximum_of_the_studys_rocks_or_as_set():
    assert end_of_stress_axis(DEFAULT) == 30
    changed = {"slate": {"max_normal_stress_MPa": 3}, "dolerite": {"max_normal_stress_MPa": 40}}
    study = merged({"study": {"rocks": ["slate"]}, "rocks": changed})
    assert end_of_stress_axis(study) == 3
    assert end_of_stress_axis(study | {"output": {"largest_stress_MPa": 7}}) == 7


def test_the_default_is_the_papers_study():
    cases = cases_of(DEFAULT)
    assert len(cases) == 36
    assert DEFAULT["study"]["realizations"] == 20
    assert len({case.label for case in cases}) == 36
    assert choices_of(DEFAULT) == choices_of(DEFAULT)
    dolerite = cases[0]
    assert (dolerite.youngs_modulus, dolerite.compressive_strength) == (78e9, 165e6)
    assert dolerite.max_normal_stress == 30e6
    assert numerics_of(DEFAULT).later_breakage_step == 2.5e-6
    assert all(effects_of(DEFAULT))


def test_the_library_and_the_configuration_have_the_same_defaults():
    import jointclosure as jc

    # but for the points of an elastic curve, which in a study meet the output's axis of stresses
    points = DEFAULT["output"]["stress_points"] - 1
    assert numerics_of(DEFAULT) == jc.Numerics(curve_points=points)
    assert choices_of(DEFAULT) == jc.Choices()
    assert effects_of(DEFAULT) == jc.Effects()


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"grid": {"cell_x": 5}}, "grid.cell_x = 5: unknown key; did you mean cells_x?"),
        ({"stuy": {}}, "stuy = {}: unknown key; did you mean study?"),
        ({"rocks": {"slate": {"youngs_modulus_GPa": -66}}}, "rocks.slate.youngs_modulus_GPa = -66: must be above 0"),
        ({"rocks": {"slate": {"poisson_ratio": 0.7}}}, "rocks.slate.poisson_ratio = 0.7: must be at most 0.5"),
        ({"rocks": {"slate": {"levels": {"poisson_ratio": [0.1, 0.7]}}}}, "poisson_ratio = 0.7"),
        ({"rocks": {"slate": {"levels": {"jrc": [5, 25]}}}}, "jrc = 25"),
        ({"rocks": {"slate": {"levels": {"jrc": [8, 5]}}}}, "rocks.slate.levels.jrc = [8, 5]: must be strictly ascending"),
        ({"rocks": {"slate": {"levels": {"jrc": [5, 6.5]}}}}, "lists the rock's own value"),
        ({"rocks": {"slate": {"levels": {"jrc": [5]}}}}, "needs at least 2 values"),
        ({"rocks": {"slate": {"max_normal_stress_MPa": 0}}}, "max_normal_stress_MPa = 0: must be above 0"),
        ({"rocks": {"slate": {"max_normal_stress_MPa": 0.4}}}, "seating_stress_MPa = 0.5: must be below"),
        ({"effects": "autom"}, "effects = 'autom': must be auto, or effects with true or false"),
        ({"choices": {"largest_radius_mm": 0.2}}, "largest_radius = 0.0002 m: must be at least the grid spacing"),
        ({"rocks": {"slate": {"max_normal_stress_MPa": 40}}, "output": {"largest_stress_MPa": 30}}, "output.largest_stress_MPa = 30: must be at least"),
        ({"rocks": {"slate": {"youngs_modulus_GPa": 0.02, "levels": {"youngs_modulus_GPa": [0.01, 0.03]}}}}, "must be below Young's modulus, 10 MPa"),
        ({"rocks": {"gneiss": {"jrc": 8}}}, "rocks.gneiss: lacks title"),
        ({"study": {"realizations": 1}}, "study.realizations = 1: must be at least 2"),
        ({"study": {"realizations": "20"}}, "study.realizations = '20': must be of type integer"),
        ({"study": {"rocks": ["dolorite"]}}, "'dolorite': not among rocks"),
        ({"study": {"name": "../elsewhere"}}, "study.name = '../elsewhere': must match"),
        ({"numerics": {"breakage_step_um": 12.5}}, "breakage_step = 1.25e-05"),
        ({"numerics": {"later_breakage_step_um": 7}}, "later_breakage_step = 7e-06"),
        ({"numerics": {"solver": "refrence"}}, "did you mean reference?"),
        ({"effects": {"substrate": False}}, "interaction = True needs substrate = True"),
        ({"effects": {"breakage": False}}, "gouge = True needs breakage = True"),
        ({"choices": {"base_radius_in_cells": 2}}, "choices.base_radius_in_cells = 2: must be at most 1"),
        ({"surface": {"jrc_relation": "yang_2001"}}, "did you mean yang?"),
    ],
)  # fmt: skip
def test_an_error_names_the_key_its_value_and_what_is_allowed(change, said):
    with pytest.raises(ConfigurationError) as error:
        checked(merged(change), SCHEMA)
    assert said in str(error.value)


def test_a_misspelt_rock_is_guessed():
    with pytest.raises(ConfigurationError, match="did you mean dolerite"):
        checked(merged({"study": {"rocks": ["dolorite"]}}), SCHEMA)


def test_all_errors_are_listed_at_once():
    with pytest.raises(ConfigurationError) as error:
        checked(merged({"grid": {"cells_x": 2}, "study": {"realizations": 1}}), SCHEMA)
    assert str(error.value).count("must be at least") == 2


def test_every_key_of_the_schema_has_a_description():
    def keys(schema, path=""):
        for name, entry in schema.get("properties", {}).items():
            yield f"{path}{name}", entry
            yield from keys(entry, f"{path}{name}.")
        extra = schema.get("additionalProperties")
        if isinstance(extra, dict):
            yield from keys(extra, f"{path}*.")
        elif schema.get("properties"):
            assert extra is False, f"{path} is not closed"

    described = dict(keys(SCHEMA))
    assert len(described) > 50
    assert all(entry.get("description") for entry in described.values())


def test_levels_beyond_three_are_named_and_ordered():
    cases = cases_of(merged({"rocks": {"slate": {"levels": {"jrc": [4, 5, 8, 9]}}}}))
    jrc = [case for case in cases if case.rock == "slate" and case.parameter == "jrc"]
    assert [case.level for case in jrc] == ["level_1", "level_2", "level_4", "level_5"]
    assert [case.jrc for case in jrc] == [4, 5, 8, 9]


def test_common_draws_share_surfaces_where_the_roughness_is_the_same():
    common = [case for case in cases_of(DEFAULT) if case.rock == "slate"]
    assert len({case.surface for case in common}) == 3
    independent = merged({"study": {"draws": "independent"}})
    own = [case for case in cases_of(independent) if case.rock == "slate"]
    assert len({case.surface for case in own}) == 9
    seeds = {wall_seed(independent, case, 0) for case in own}
    assert len(seeds) == 9
    assert len({wall_seed(DEFAULT, case, 0) for case in common}) == 1


def test_adding_reordering_or_dropping_cases_changes_no_surface():
    fewer = merged({"study": {"rocks": ["slate", "dolerite"]},
                    "rocks": {"slate": {"levels": {"jrc": [4, 5, 8]}}}})  # fmt: skip
    for settings in (DEFAULT, merged({"study": {"draws": "independent"}})):
        changed = fewer | {"study": settings["study"] | {"rocks": ["slate", "dolerite"]}}

        def seeds(configuration):
            return {
                (case.rock, case.parameter, case.level): wall_seed(configuration, case, 3)
                for case in cases_of(configuration)
            }

        before, after = seeds(settings), seeds(changed)
        shared = set(before) & set(after)
        assert len(shared) > 10
        assert all(before[key] == after[key] for key in shared)


@pytest.mark.parametrize(
    ("written", "read"),
    [(12.5, 12.5e-6), (0.1, 0.1e-6), (1e-9, 1e-15), (3e-7, 3e-13), (1e22, 1e16), (0, 0.0)],
)
def test_a_value_with_a_unit_is_read_as_the_decimal_number_that_was_written(written, read):
    settings = to_si({"step_um": written, "steps_um": [written], "none_um": None})
    assert settings == {"step": read, "steps": [read], "none": None}


def test_an_infinite_strength_can_be_written():
    assert to_si({"strength_MPa": float("inf")}) == {"strength": float("inf")}


@pytest.mark.parametrize(
    "name", ["../paper", "a/b", "/tmp/a", "..", "", "a\\b", "~", "$HOME", "a b"]
)
def test_no_name_leads_out_of_the_results_folder(name):
    rock = DEFAULT["rocks"]["slate"]
    for change in (
        {"study": {"name": name}},
        {"study": {"surfaces_of": name}},
        {"study": {"rocks": [name]}, "rocks": {name: rock}},
    ):
        with pytest.raises(ConfigurationError):
            checked(merged(change), SCHEMA)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("study:\n  name: !!python/object/apply:os.system ['touch ran']\n", "not plain YAML"),
        ("study: !!python/name:os.system\n", "not plain YAML"),
        (
            "__use_yte__: true\nstudy:\n  name: ?open('ran', 'w').name\n",
            "templates are not allowed",
        ),
        ("__use_yte__: 1\n?if True:\n  grid: {}\n", "templates are not allowed"),
        ("- a list\n", "must hold keys and values"),
        ("grid: {cells_x: [\n", "not plain YAML"),
    ],
)
def test_a_configuration_is_plain_data_and_runs_nothing(tmp_path, monkeypatch, text, said):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "mine.yaml").write_text(text)
    with pytest.raises(ConfigurationError, match=rf"mine\.yaml: .*{said}"):
        read_plain("mine.yaml")
    assert not (tmp_path / "ran").exists()


def test_auto_is_short_for_all_effects_to_two_percent():
    whole = written_out(merged({"effects": "auto"}))
    assert choice_tolerance(checked(whole, SCHEMA)) == 0.02
    assert all(effects_of(whole))
    assert choice_tolerance(merged({})) is None
    assert written_out(DEFAULT) is DEFAULT


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"effects": {"auto": 1.5}}, "effects.auto = 1.5: must be below 1"),
        ({"rocks": {"slate": {"effects": {"breakage": False}}}}, "gouge"),
        ({"rocks": {"slate": {"effects": {"glue": True}}}}, "effects.glue = True: unknown key"),
        (
            {"effects": {"auto": 0.1}, "study": {"realizations": 1}},
            "study.realizations = 1",
        ),
    ],
)
def test_effects_that_cannot_be_are_refused(changes, said):
    with pytest.raises(ConfigurationError) as error:
        checked(merged(changes), SCHEMA)
    assert said in str(error.value)

"""What the configuration of a study may say, and the cases that it gives."""

import functools
import inspect
import math
import re
import shutil
from contextlib import chdir, nullcontext
from pathlib import Path

import pandas as pd
import pytest

import jointclosure as jc
from jointclosure.compilation.cache_folder import PACKAGE
from jointclosure.ensembles.quantities import QUANTITIES
from jointclosure.joint.load import SEATING_STRESS
from jointclosure.parameters.units import in_unit, to_si
from studies.frame.cases import block_settings, cases_of
from studies.frame.configuration import read_stored, sections, written_out
from studies.frame.experiments import experiment_named
from studies.frame.joint_tables import as_table
from studies.frame.settings import seeds_of
from studies.frame.simulation import close_points
from studies.frame.yaml_files import ConfigurationError, read_plain, with_places
from tests.processes import python
from tests.studied import DEFAULT, ROOT, study_of, tiny

HARD_CASES = ROOT / "studies/verification/hard_cases.yaml"
STUDIES = sorted({*ROOT.glob("config/*.yaml"), *ROOT.glob("studies/*/*.yaml")} - {HARD_CASES})


@pytest.mark.parametrize("path", STUDIES, ids=lambda p: p.stem)
def test_every_configuration_in_the_project_is_valid(path):
    assert study_of(read_plain(path)).study.name


def test_the_default_is_the_papers_study():
    study = study_of()
    cases = cases_of(study)
    assert len({case.label for case in cases}) == len(cases) == 36
    assert study.study.realizations == 20
    dolerite = cases[0].conditions
    assert dolerite.rock[:3] == (78e9, 0.2, 165e6)
    assert dolerite.max_normal_stress == 30e6
    assert study.numerics.later_breakage_step == 2.5e-6
    assert all(all(case.conditions.effects) for case in cases)


def test_the_library_and_the_configuration_have_the_same_defaults():
    study = study_of()
    # but for the points of an elastic curve, which in a study meet the output's axis of stresses,
    # and the paper's words on strength, which leave the first cycle without a limit
    assert study.numerics == jc.Numerics(curve_points=study.output.stress_points - 1)
    assert study.choices == jc.Choices(strength_bound="none")
    assert study.rocks["slate"].effects == jc.Effects()
    surface = dict(study.surface)
    of_fit = _defaults(jc.fit)
    assert surface.items() <= _defaults(jc.wall_pair).items()
    assert of_fit["roll_off"] is None  # natural walls have waves of all lengths
    shared = (of_fit.keys() & surface.keys()) - {"roll_off"}
    assert {of_fit[name] == surface[name] for name in shared} == {True}
    for function in (jc.simulate, jc.close, jc.fit, jc.simulate_ensemble):
        assert _defaults(function)["seating_stress"] is None
    assert study.seating_stress == SEATING_STRESS


def _defaults(function) -> dict:
    """Return the default values of a function's arguments by name."""
    arguments = inspect.signature(function).parameters
    return {name: argument.default for name, argument in arguments.items()}


_WITH_GRAIN_SIZE = """
import jointclosure as jc
from jointclosure.cli.options import UNITS
from jointclosure.joint.rocks import named_rock
from studies.frame.cases import cases_of
from studies.paper.tables_1_to_3 import property_heading, rock_table
from studies.verification.hard_case_keys import RockKeys
from tests.studied import study_of

assert named_rock("granite").grain_size == 1e-3
finer = {"grain_size_mm": 0.5, "levels": {"grain_size_mm": [0.2, 2]}}
study = study_of({"study": {"rocks": ["slate", "dolerite"]}, "rocks": {"slate": finer}})
assert study.rocks["slate"].levels["grain_size"] == (0.2e-3, 0.5e-3, 2e-3)
assert study.rocks["dolerite"].intact.grain_size == 1e-3
assert [c.value for c in cases_of(study) if c.parameter == "grain_size"] == [0.2e-3, 2e-3]
assert property_heading("grain_size") == "Grain size d (mm)"
assert (UNITS["grain_size"], "grain_size" in RockKeys.model_fields) == ("mm", True)
assert "grain_size_mm" in rock_table(study.rocks)
try:
    study_of({"rocks": {"slate": {"grain_size_mm": 500}}})
except jc.InputError as error:
    assert "not usual" in str(error), error
else:
    raise AssertionError("a grain of 500 mm is taken")
"""


def test_a_field_of_rock_with_its_metadata_is_a_property_everywhere(tmp_path):
    """The recipe of CONTRIBUTING.md, on a copy of the package."""
    ignored = shutil.ignore_patterns("__*__", "compiled")
    copy = shutil.copytree(PACKAGE, tmp_path / "jointclosure", ignore=ignored)
    file = copy / "parameters/__init__.py"
    text = file.read_text(encoding="utf-8")
    end = "\n\n\nOF_ROCK = "
    assert end in text
    field = 'Annotated[float, Property("grain size", "mm", "d", usual=(1e-6, 0.05))] = 1e-3'
    file.write_text(text.replace(end, f"\n    grain_size: {field}{end}"), encoding="utf-8")
    python("-c", _WITH_GRAIN_SIZE, cwd=tmp_path, PYTHONPATH=f"{tmp_path}:{ROOT}")


ACCURATE = {"accuracy": {"within": 0.1}}


@pytest.mark.parametrize(
    ("change", "printed"),
    [({"grid": {"cell_x": 5}}, "grid.cell_x = 5: unknown key; did you mean cells_x?"),
     ({"stuy": {}}, "stuy = {}: unknown key; did you mean study?"),
     ({"rocks": {"slate": {"youngs_modulus_GPa": -66}}},
      "rocks.slate.youngs_modulus_GPa = -66: must be greater than 0"),
     ({"rocks": {"slate": {"levels": {"poisson_ratio": [0.1, 0.7]}}}}, "poisson_ratio = 0.7"),
     ({"rocks": {"slate": {"levels": {"jrc": [8, 5]}}}},
      "rocks.slate.levels.jrc = [8, 5]: must be strictly ascending"),
     ({"rocks": {"slate": {"levels": {"jrc": [5, 6.5]}}}},
      "must not contain the value of the rock"),
     ({"rocks": {"slate": {"max_normal_stress_MPa": 0.4}}, "seating_stress_MPa": 0.5},
      "seating_stress_MPa = 0.5: must be at most 0.9"),
     ({"study": {"realizations": 4000}},
      "statistics.control_variates = 4000: must be more than the 4000 surfaces"),
     ({"effects": "autom"}, "effects = 'autom': must be auto, or effects with true or false"),
     ({"choices": {"largest_radius_mm": 0.2}},
      "largest_radius = 0.0002 m: must be at least the grid spacing"),
     ({"rocks": {"slate": {"max_normal_stress_MPa": 40}}, "output": {"largest_stress_MPa": 30}},
      "output.largest_stress_MPa = 30: must be at least"),
     ({"study": {"unusual_values": "allow"}, "rocks": {"slate": {"youngs_modulus_GPa": 0.02,
       "levels": {"youngs_modulus_GPa": [0.01, 0.03]}}}},
      "must be below Young's modulus, 10 MPa"),
     ({"rocks": {"gneiss": {"jrc": 8}}}, "rocks.gneiss: lacks youngs_modulus_GPa"),
     ({"study": {"realizations": "20"}}, "study.realizations = '20': must be a valid integer"),
     ({"seating_stress_MPa": "0,5"}, "the decimal sign is a point: write 0.5"),
     ({"study": {"rocks": "slate"}}, "study.rocks = 'slate': must be a list of values"),
     ({"rocks": {"slate": {"jrc": [6, 9]}}}, "not a list; further values of a property of rock"),
     ({"study": {"rocks": ["dolorite"]}}, "'dolorite': must be one of rocks"),
     ({"numerics": {"breakage_step_um": 12.5}}, "breakage_step = 1.25e-05"),
     ({"effects": {"substrate": False}}, "substrate = False needs interaction = False"),
     ({"surface": {"mismatch_wavelength_mm": 1, "correlation": 0.5}},
      "correlation = 0.5: must be 0 if mismatch_wavelength is given"),
     ({"effects": {"interaction": False}, "numerics": {"idle_interaction": 0.02}},
      "idle_interaction = 0.02: has no effect without interaction"),
     ({"effects": {"auto": 1.5}}, "effects.auto = 1.5: must be less than 1"),
     ({"rocks": {"slate": {"effects": {"breakage": False}}}}, "gouge"),
     ({"rocks": {"slate": {"effects": {"glue": True}}}}, "effects.glue = True: unknown key"),
     ({"study": {"name": "../paper"}}, "study.name = '../paper': must match"),
     ({"study": {"surfaces_of": "$HOME"}}, "study.surfaces_of = '$HOME': must match"),
     ({"study": {"rocks": ["a b"]}, "rocks": {"a b": DEFAULT["rocks"]["slate"]}}, "must match"),
     ({"study": ACCURATE, "numerics": {"breakage": "resolved", "tolerance": 0.001}}, "tolerance = 0.001: must"),
     ({"study": ACCURATE, "statistics": {"control_variates": 150}}, "control_variates = 150: must be more"),
     ({"rocks": {"slate": {"youngs_modulus_GPa": math.nan}}}, "youngs_modulus_GPa = nan: must be"),
     ({"rocks": {"slate": {"levels": {"jrc": [5, math.inf]}}}}, "levels.jrc = inf: must be"),
     ({"choices": {"strength_bound": "base"}, "numerics": {"breakage": "resolved"},
       "rocks": {"slate": {"max_normal_stress_MPa": 300}}},
      "rocks.slate.max_normal_stress_MPa = 300: must be less than 135 MPa, which all cells"),
     ({"choices": {"strength_bound": "base"}, "numerics": {"breakage": "resolved"},
       "rocks": {"slate": {"levels": {"compressive_strength_MPa": [20, 200]}}}},
      "with choices.strength_bound: base and rocks.slate.levels.compressive_strength_MPa = 20"),
     ({"study": ACCURATE, "choices": {"largest_radius_mm": 0.25}},
      "rocks.slate.max_normal_stress_MPa = 30: must be less than"),
     ({"study": {"accuracy": {"within": 1.5}}}, "accuracy.within = 1.5: must be less than 1"),
     ({"study": {"accuracy": {"within": 0.1, "of": "median"}}}, "mean, interval, stiffness")],
)  # fmt: skip
def test_an_error_names_its_key_with_what_is_allowed(change, printed):
    with pytest.raises(ConfigurationError, match=re.escape(printed)):
        study_of(change)


BOUNDED = {"choices": {"strength_bound": "base"}, "numerics": {"breakage": "resolved"}}


def test_one_line_lists_all_levels_that_do_not_carry_the_stress():
    levels = {"compressive_strength_MPa": [20, 25, 200]}
    with pytest.raises(ConfigurationError) as refused:
        study_of(BOUNDED, {"rocks": {"slate": {"levels": levels}}})
    (line,) = str(refused.value).splitlines()[1:]
    assert line.endswith(
        "base (with rocks.slate.levels.compressive_strength_MPa = 20: 17 MPa, 25: 21.2 MPa)"
    )


def test_levels_that_carry_as_much_as_a_rock_that_is_refused_are_not_listed():
    """Young's modulus does not change the strength."""
    levels = {"compressive_strength_MPa": [20, 400], "youngs_modulus_GPa": [60, 72]}
    slate = {"max_normal_stress_MPa": 200, "levels": levels | {"poisson_ratio": None}}
    with pytest.raises(ConfigurationError) as refused:
        study_of(BOUNDED, {"rocks": {"slate": slate}})
    (line,) = str(refused.value).splitlines()[1:]
    assert "must be less than 135 MPa, which all cells" in line
    assert line.endswith("base (with rocks.slate.levels.compressive_strength_MPa = 20: 17 MPa)")


def test_levels_beyond_three_are_named_in_their_order():
    cases = cases_of(study_of({"rocks": {"slate": {"levels": {"jrc": [4, 5, 8, 9]}}}}))
    jrc = [case for case in cases if case.rock == "slate" and case.parameter == "jrc"]
    assert [case.level for case in jrc] == ["level_1", "level_2", "level_4", "level_5"]
    assert [case.jrc for case in jrc] == [4, 5, 8, 9]


def seeds_by_case(study):
    """Return the seed of one realisation of each case, by rock, parameter and level."""
    blocks = ((case, block_settings(study, case, range(3, 4))) for case in cases_of(study))
    return {case[1:4]: seeds_of(block)[0] for case, block in blocks}


@functools.cache
def seeds_before_and_after(draws):
    """Seeds by case of the default study, and of one with fewer rocks and levels."""
    fewer = {"study": {"rocks": ["slate", "dolerite"]},
             "rocks": {"slate": {"levels": {"jrc": [4, 5, 8]}}}}  # fmt: skip
    common = {"study": {"draws": draws}}
    return [seeds_by_case(study_of(common, each)) for each in ({}, fewer)]


@pytest.mark.parametrize(("draws", "different"), [("independent", 36), ("common", 4)])
def test_only_common_draws_share_the_seeds_of_a_rock(draws, different):
    before, _ = seeds_before_and_after(draws)
    assert len(set(before.values())) == different


@pytest.mark.parametrize("draws", ["independent", "common"])
def test_other_cases_change_no_surface(draws):
    before, after = seeds_before_and_after(draws)
    shared = set(before) & set(after)
    assert len(shared) > 10
    assert all(before[key] == after[key] for key in shared)


@pytest.mark.parametrize(("um", "m"), [(12.5, 12.5e-6), (1e-9, 1e-15), (1e22, 1e16), (0, 0.0)])
def test_a_value_with_a_unit_is_read_as_the_decimal_number_that_was_written(um, m):
    settings = to_si({"step_um": um, "steps_um": [um], "none_um": None})
    assert settings == {"step": m, "steps": [m], "none": None}
    assert in_unit(m, "um") == um


def test_the_stress_axis_ends_at_the_largest_maximum_of_the_studys_rocks_or_as_set():
    assert study_of().output.largest_stress == 30e6
    changed = {"slate": {"max_normal_stress_MPa": 3}, "dolerite": {"max_normal_stress_MPa": 40}}
    change = {"study": {"rocks": ["slate"]}, "rocks": changed}
    assert study_of(change).output.largest_stress == 3e6
    assert study_of(change, {"output": {"largest_stress_MPa": 7}}).output.largest_stress == 7e6


def test_closures_count_from_half_a_megapascal_or_from_a_tenth_of_a_small_maximum():
    low = {"rocks": {"slate": {"max_normal_stress_MPa": 0.4}}}
    assert study_of(low, {"study": {"rocks": ["slate"]}}).seating_stress == pytest.approx(0.04e6)
    assert study_of(low, {"seating_stress_MPa": 0.1}).seating_stress == 0.1e6


def test_a_study_is_read_again_from_the_keys_that_it_left():
    left = study_of({"study": {"realizations_per_job": 3}}).stated
    del left["study"]["realizations_per_job"]
    assert dict(read_stored(left)) == dict(study_of())


def test_auto_is_short_for_all_effects_to_two_percent():
    study = study_of(written_out({"effects": "auto"}))
    assert study.effects.auto == 0.02
    assert all(study.rocks["slate"].effects)
    assert study_of().effects.auto is None
    assert written_out(DEFAULT) is DEFAULT


# Files of a configuration that are damaged or meant to do harm: one line with file and reason


BOMB = "a: &a [x, x, x, x, x, x, x, x, x]\n" + "".join(
    f"{later}: &{later} [{', '.join(9 * ['*' + earlier])}]\n"
    for earlier, later in zip("abcdefgh", "bcdefghi", strict=True)
)
MERGES = "a: &a {x: 1}\n" + "".join(
    f"{later}: &{later} {{<<: [{', '.join(10 * ['*' + earlier])}]}}\n"
    for earlier, later in zip("abcdefghi", "bcdefghij", strict=True)
)
CHAIN = "a0: &a0 [1]\n" + "".join(f"a{i}: &a{i} [*a{i - 1}]\n" for i in range(1, 60))
PLAIN = "".join(f"k{i:06}: {i % 10}\n" for i in range(90_909))  # 1 MB
FILES = {
    "empty": (b"", "is empty"),
    "a list": (b"- study\n- grid\n", "must contain keys and values, not ['study', 'grid']"),
    "latin-1": ("study: {name: caf\xe9}\n".encode("latin-1"), "must be UTF-8 text"),
    "a tag": (b"study:\n  name: !!python/object/apply:os.system ['touch ran']\n", "not plain YAML"),
    "a template": (b"__use_yte__: true\nstudy:\n  name: ?open('ran', 'w').name\n", "left out"),
    "a key twice": (b"grid: {cells_x: 5}\ngrid: {cells_y: 6}\n", "line 2: the key grid must be"),
    "an alias bomb": (BOMB.encode(), "its aliases expand to more than 100000"),
    "a recursive anchor": (b"study: &a\n  rocks: *a\n", "an alias refers to itself"),
    "deep": (b"study: " + 5000 * b"[" + 5000 * b"]", "nested"),
    "deep maps": (100_000 * b"{a: " + b"1" + 100_000 * b"}", "nested more than 40 levels"),
    "deep by aliases": (CHAIN.encode(), "nested more than 40 levels"),
    "a merge bomb": (MERGES.encode(), "its aliases expand to more than 100000"),
    "10 MB of plain keys": (11 * PLAIN.encode(), "has 11 MB, and a configuration at most 1 MB"),
    "too many plain keys": (PLAIN.encode(), "has more than 100000 keys and values"),
    "a tag of YAML": (b"flow: !!bool maybe\n", "line 1: the tag tag:yaml.org,2002:bool must be"),
    "a tag of another kind": (b"grid: !!int {x: 1}\n", "the tag tag:yaml.org,2002:int must be left"),
    "an unknown anchor": (b"study: *a\n", "line 1: found undefined alias"),
    "minutes": (b"rocks:\n  slate:\n    youngs_modulus_GPa: 1:30\n", "line 3: 1:30 must be"),
    "octal": (b"grid: {cells_x: 010}\n", "line 1: 010 must be a decimal"),
    "a number as a key": (b"grid: {5: 5}\n", "the key 5 must be a text"),
    "two documents": (b"grid: {}\n---\nstudy: {}\n", "not plain YAML: "),
}  # fmt: skip


@pytest.mark.parametrize("kind", FILES)
def test_a_file_that_is_no_configuration_is_refused_in_one_line(kind, tmp_path):
    content, printed = FILES[kind]
    path = tmp_path / "mine.yaml"
    path.write_bytes(content)
    one_line = rf"\A{re.escape(str(path))}: .*{re.escape(printed)}.*\Z"
    with pytest.raises(ConfigurationError, match=one_line):
        read_plain(path)


def test_what_is_no_file_is_refused_without_being_read(tmp_path):
    for path in (tmp_path, Path("/dev/zero")):
        with pytest.raises(ConfigurationError, match="must be a file"):
            read_plain(path)


def test_a_value_may_be_nested_forty_levels_deep(tmp_path):
    path = tmp_path / "mine.yaml"
    for levels, refused in ((40, False), (41, True)):
        path.write_text((levels - 1) * "{a: " + "{a: 1}" + (levels - 1) * "}")
        with pytest.raises(ConfigurationError) if refused else nullcontext():
            read_plain(path)


def test_anchors_that_repeat_a_few_values_are_kept(tmp_path):
    path = tmp_path / "mine.yaml"
    path.write_text("a: &some {x: 1, y: 2.5e-3}\nb: *some\nc: {<<: *some, y: -3}\n")
    few = {"x": 1, "y": 2.5e-3}
    assert read_plain(path) == {"a": few, "b": few, "c": {"x": 1, "y": -3}}


PLACED = [
    ("grid.cells_x = 2: must", "  mine.yaml, line 2: grid.cells_x = 2: must"),
    ("grid.cell_y = 2: unknown", "  mine.yaml, line 2: grid.cell_y = 2: unknown"),
    ("seating_stress_MPa = 9: must", "  usual.yaml, line 1: seating_stress_MPa = 9: must"),
    ("rocks.tuff: lacks jrc", "  mine.yaml, line 4: rocks.tuff: lacks jrc"),
    ("largest_radius = 0.1 m: must", "  mine.yaml, line 5: largest_radius = 0.1 m: must"),
    ("jrc = 60: holds", "  jrc = 60: holds"),  # of which rock is not known
    ("a text without a key", "  a text without a key"),
]


@pytest.mark.parametrize(("line", "placed"), PLACED)
def test_a_message_names_file_and_line_of_the_key_with_which_it_begins(tmp_path, line, placed):
    mine = (
        "study: {name: mine}\ngrid: {cells_x: 2}\nrocks:\n  tuff: {jrc: 60}\n"
        "choices: {largest_radius_mm: 100}\n"
    )
    usual = "seating_stress_MPa: 9\ngrid: {cells_x: 50}\nrocks: {slate: {jrc: 4}}\n"
    with chdir(tmp_path):
        Path("mine.yaml").write_text(mine)
        Path("usual.yaml").write_text(usual)
        message = with_places(f"configuration:\n  {line}", ["usual.yaml", "mine.yaml"])
    assert message == f"configuration:\n{placed}"


# What holds of every experiment: bad designs are refused by key, and jobs change no bit


TINY = {name: tiny(name) for name in sections()}


REFUSED = [
    ("assessment", {"assessment": {"joints": 1}}, "joints = 1: must be greater than or equal to 2"),
    ("assessment", {"assessment": {"stress_MPa": [0.5]}}, "stress_MPa = 0.5: must be more than"),
    ("assessment", {"numerics": {"breakage": "resolved"}, "choices": {"strength_bound": "base"},
      "assessment": {"stress_MPa": [200]}}, "assessment.stress_MPa = 200: must be less than"),
    ("measured_joints", {"choices": {"strength_bound": "base"},
      "measured_joints": {"compressive_strength_MPa": [5]}},
     "and measured_joints.compressive_strength_MPa = 5"),
    ("global_sensitivity", {"global_sensitivity": {"rows": 48}}, "rows = 48: must be a power of 2"),
    ("global_sensitivity", {"global_sensitivity": {"inputs": {"jrc": {"values": [6, 7]}}}}, "inputs.jrc: must have either"),
    ("global_sensitivity", {"global_sensitivity": {"inputs": {"jrc": {"between": [9, 6]}}}}, "[9.0, 6.0]: must ascend"),
    ("global_sensitivity", {"global_sensitivity": {"inputs": {"jrc": {"between": [6, 60]}}}}, "rocks.dolerite.jrc = 60"),
    ("global_sensitivity", {"global_sensitivity": {"inputs": {"jrc": {"key": "grid.cells_x", "between": [9, 64]}}}}, "begin"),
    ("misalignment", {"misalignment": {"tilt_degrees": [0.1]}}, "[0.1]: must have 0 among"),
    ("measured_joints", {"study": {"cycles": 1}}, "study.cycles = 1: must be at least 2 (measured"),
    ("measured_joints", {"study": {"rocks": ["slate", "dolerite"]}}, "must be one rock (measured"),
    ("measured_joints", {"measured_joints": {"reseating_shift_in_cells": [20]}},
     "reseating_shift_in_cells = 20: must leave at least 8 of grid.cells_x = 18"),
    ("misalignment", {"misalignment": {"rotation_degrees": [360]}}, "rotation_degrees = 360"),
    ("misalignment", {"grid": {"cells_y": 20}}, "grid.cells_x = 24: must be cells_y (20)"),
    ("mismatch", {"mismatch": {"shift_in_cells": [1]}}, "shift_in_cells = [1]: must have 0 among"),
    ("mismatch", {"mismatch": {"wavelength_mm": [-1]}}, "wavelength_mm = -1: must be greater"),
    ("mismatch", {"surface": {"correlation": 0.5}}, "the study sets surface.mismatch_wavelength"),
    ("size", {"size": {"spacing_mm": [0.15, 0.25]}}, "spacing_mm = 0.25: must be a multiple of"),
    ("size", {"size": {"patch_mm": [3, 4]}}, "patch_mm = 3: must be a whole part of 4"),
    ("size", {"size": {"spectra": {"flat": {"roll_off_mm": 0.2}}}}, "spectra.flat: roll_off"),
]  # fmt: skip


@pytest.mark.parametrize(("name", "change", "reason"), REFUSED)
def test_a_design_that_cannot_be_closed_is_refused_by_its_key(name, change, reason):
    with pytest.raises(ConfigurationError, match=re.escape(reason)):
        experiment_named(name).check(study_of(TINY[name], change))


@pytest.mark.parametrize("name", sections())
def test_a_study_without_the_section_does_not_run_the_experiment_nor_bear_its_name(name):
    assert name not in study_of().study_sections
    with pytest.raises(ConfigurationError, match=f"study.name = '{name}'"):
        study_of({"study": {"name": name}})


@pytest.mark.parametrize("name", sections())
def test_a_point_closed_alone_has_the_bits_that_it_has_in_its_job(name):
    experiment = experiment_named(name)
    assert set(experiment.quantities) <= set(QUANTITIES)
    points = list(next(iter(experiment.jobs(study_of(TINY[name])).values())))[:2]
    together, alone = (
        as_table([close_points(part, experiment.quantities)]).drop(columns="seconds")
        for part in (points, points[-1:])
    )
    own = together.tail(len(alone)).reset_index(drop=True)
    pd.testing.assert_frame_equal(own[alone.columns], alone, check_exact=True)


# Texts reach tables, figures, file names and pages


ON_SCANS = {"jrc": None, "levels": {"jrc": None}}


@pytest.mark.parametrize(
    ("change", "line"),
    [
        ({"rocks": {"slate": {"title": "a\0b"}}}, "rocks.slate.title = 'a\\x00b': must not have the character U+0000"),
        ({"rocks": {"slate": {"title": "a\nb"}}}, "rocks.slate.title = 'a\\nb': must not have the character U+000A"),
        ({"rocks": {"slate": {"title": "a\u202eb"}}}, "must not have the character U+202E"),
        ({"rocks": {"slate": {"title": "\ud800"}}}, "must not have the character U+D800"),
        ({"rocks": {"slate": {"title": " "}}}, "rocks.slate.title = ' ': must not be blank"),
        ({"rocks": {"slate": {"measured": {"file": "a\x1b[2J"}}}}, "rocks.slate.measured.file = 'a\\x1b[2J': must not have"),
        ({"rocks": {"slate": ON_SCANS | {"walls": {"upper": "a\0", "lower": "flat"}}}}, "rocks.slate.walls.upper = 'a\\x00': must not have"),
        ({"rocks": {"slate": ON_SCANS | {"walls": {"upper": "a", "lower": "flat", "variable": "z\0"}}}}, "rocks.slate.walls.variable = 'z\\x00': must not have"),
        ({"rocks": {"sl\0": {}}}, "rocks.'sl\\x00': must not have the character U+0000"),
        ({"study": {"rocks": ["slate\t"]}}, "study.rocks = 'slate\\t': must not have the character U+0009"),
        ({"grid": {"spacing_mm": 10**400}}, "must be a number below 1e300"),
        ({"study": {"root_seed": 10**400}}, "must be a number below 1e300"),
    ],
)  # fmt: skip
def test_a_text_or_number_that_no_table_or_figure_can_hold_is_refused_by_its_key(change, line):
    with pytest.raises(ConfigurationError, match=re.escape(line)):
        study_of(change)


@pytest.mark.parametrize(
    ("change", "line"),
    [
        ({"levels": {"jrc": [8]}}, "levels.jrc = [8]: must have at least 2 items, not 1"),
        (
            {"compressive_strength_MPa": "65e6"},
            "must be a valid number; YAML reads it as text: write 65.0e+6; the key is in MPa",
        ),
        (
            {"youngs_modulus_GPa": "18 GPa"},
            "must be a valid number; write a number without a unit; the key is in GPa",
        ),
        ({"levels": {"youngs_modulus_GPa": ["18 GPa", 3]}}, "without a unit; the key is in GPa"),
        ({"jrc": "8 mm"}, "must be a valid number; write a number without a unit"),
        ({"jrc": "8,5"}, "the decimal sign is a point: write 8.5"),
    ],
)
def test_a_number_that_is_a_text_is_refused_with_how_to_write_it(change, line):
    with pytest.raises(ConfigurationError) as error:
        study_of({"rocks": {"slate": change}})
    assert str(error.value).rstrip().endswith(line)


@pytest.mark.parametrize("text", ["a:\n\tb: 1\n", "a:\n  b: 1\n\tc: 2\n"])
def test_a_tab_of_a_configuration_is_named(tmp_path, text):
    path = tmp_path / "mine.yaml"
    path.write_text(text)
    with pytest.raises(ConfigurationError, match="the line has a tab: write spaces in its place"):
        read_plain(path)
    path.write_text("a: [1,\n")
    with pytest.raises(ConfigurationError) as error:
        read_plain(path)
    assert "has a tab" not in str(error.value)


def test_two_rocks_of_a_study_have_two_titles():
    alike = {"rocks": {"slate": {"title": "Dolerite "}}}
    with pytest.raises(ConfigurationError, match=r"rocks\.slate\.title = 'Dolerite ': must differ"):
        study_of(alike)
    study_of(alike, {"study": {"rocks": ["slate"]}})


def test_a_rock_without_a_title_is_written_as_its_key_with_a_capital():
    rock = {key: value for key, value in DEFAULT["rocks"]["slate"].items() if key != "title"}
    study = study_of(
        {"rocks": {"buntsandstein": rock, "my_rock_2": rock}},
        {"study": {"rocks": ["buntsandstein", "my_rock_2", "slate"]}},
    )
    assert study.titles == {
        "buntsandstein": "Buntsandstein",
        "my_rock_2": "My rock 2",
        "slate": "Slate",
    }


def test_a_title_is_written_as_it_is_typed():
    assert study_of({"rocks": {"slate": {"title": "slate of Wales"}}}).titles["slate"] == (
        "slate of Wales"
    )


def test_a_title_may_have_signs_of_any_kind():
    study_of({"rocks": {"slate": {"title": "Grès\u00a0des Vosges, 5 $ & 3 $ {x_1} 花崗岩"}}})


# Numbers that look like a slip of units are refused before anything runs


SLIPS = {
    "MPa for GPa": ({"rocks": {"slate": {"youngs_modulus_GPa": 66000, "levels": {"youngs_modulus_GPa": None}}}}, "rocks.slate.youngs_modulus_GPa = 66000"),
    "a level in MPa": ({"rocks": {"slate": {"levels": {"youngs_modulus_GPa": [60, 72000]}}}}, "rocks.slate.levels.youngs_modulus_GPa = 72000"),
    "a stress in Pa": ({"rocks": {"slate": {"max_normal_stress_MPa": 30e6}}}, "rocks.slate.max_normal_stress_MPa = 30000000"),
    "um for mm": ({"grid": {"spacing_mm": 250}}, "grid.spacing_mm = 250"),
    "a step in m": ({"numerics": {"displacement_step_um": 12.5e-6, "breakage_step_um": 1e-6}}, "numerics.displacement_step_um = 1.25e-05"),
    "a roll-off in um": ({"surface": {"roll_off_mm": 3000}}, "roll_off"),
    "a mismatch in um": ({"surface": {"mismatch_wavelength_mm": 1000}}, "mismatch_wavelength"),
    "a radius in um": ({"choices": {"largest_radius_mm": 20000}}, "choices.largest_radius_mm = 20000"),
}  # fmt: skip


def found_in(change, **study):
    """Return the lines of the error that a study raises; none if it is accepted."""
    try:
        study_of(change, {"study": study})
    except ConfigurationError as error:
        return str(error).splitlines()
    return []


@pytest.mark.parametrize("slip", SLIPS)
def test_a_slip_of_units_is_refused(slip):
    change, printed = SLIPS[slip]
    (line,) = (line for line in found_in(change) if printed in line)
    assert "not usual of rock" in line
    assert "study.unusual_values: allow takes it as it is" in line


@pytest.mark.parametrize("slip", SLIPS)
def test_an_unusual_value_may_be_taken_as_it_is(slip):
    """It may contradict another key all the same."""
    change, _ = SLIPS[slip]
    assert not any("not usual" in line for line in found_in(change, unusual_values="allow"))


def test_rocks_that_are_not_studied_may_be_what_they_are():
    tuff = {"title": "T", "youngs_modulus_GPa": 1e-9, "poisson_ratio": 0.2, "jrc": 8,
            "compressive_strength_MPa": 1, "max_normal_stress_MPa": 1, "levels": {}}  # fmt: skip
    study_of({"rocks": {"tuff": tuff}})
    with pytest.raises(ConfigurationError, match="not usual"):
        study_of({"rocks": {"tuff": tuff}, "study": {"rocks": ["tuff"]}})

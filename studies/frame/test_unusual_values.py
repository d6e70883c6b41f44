"""Numbers that are none, or that look like a slip of units, are refused before anything runs."""

import pytest
import yaml

import jointclosure as jc
from studies.frame.files import ConfigurationError
from tests.studied import study_of

USUAL = {"spacing": 0.25e-3, "rock": jc.Rock(78e9, 0.2, 165e6), "max_normal_stress": 1e6}


NO_NUMBERS = (".nan", ".inf", "-.inf", "1.0e+400", "1e400")
FINITE = (
    "rocks.slate.youngs_modulus_GPa", "rocks.slate.jrc", "grid.spacing_mm", "seating_stress_MPa",
    "choices.largest_radius_mm", "numerics.displacement_step_um", "statistics.significance",
    "output.largest_stress_MPa", "effects.auto", "rocks.slate.levels.youngs_modulus_GPa",
)  # fmt: skip


@pytest.mark.parametrize(
    ("key", "written"),
    [*((key, ".nan") for key in FINITE), *((FINITE[0], written) for written in NO_NUMBERS[1:])],
)
def test_what_is_no_finite_number_is_refused_by_its_key(key, written):
    value = [60, yaml.safe_load(written)] if "levels" in key else yaml.safe_load(written)
    for part in reversed(key.split(".")):
        value = {part: value}
    with pytest.raises(ConfigurationError) as error:
        study_of(value)
    assert f"  {key} = " in str(error.value)
    assert "must be" in str(error.value)


SLIPS = {
    "MPa for GPa": ({"rocks": {"slate": {"youngs_modulus_GPa": 66000, "levels": {"youngs_modulus_GPa": None}}}}, "rocks.slate.youngs_modulus_GPa = 66000"),
    "a level in MPa": ({"rocks": {"slate": {"levels": {"youngs_modulus_GPa": [60, 72000]}}}}, "rocks.slate.levels.youngs_modulus_GPa = 72000"),
    "a stress in Pa": ({"rocks": {"slate": {"max_normal_stress_MPa": 30e6}}}, "rocks.slate.max_normal_stress_MPa = 30000000"),
    "um for mm": ({"grid": {"spacing_mm": 250}}, "grid.spacing_mm = 250"),
    "a step in m": ({"numerics": {"displacement_step_um": 12.5e-6, "breakage_step_um": 1e-6}}, "numerics.displacement_step_um = 1.25e-05"),
    "a radius in um": ({"choices": {"largest_radius_mm": 20000}}, "choices.largest_radius_mm = 20000"),
}  # fmt: skip


def found_in(change, **study):
    """What is said against a study."""
    try:
        study_of(change, {"study": study})
    except ConfigurationError as error:
        return str(error).splitlines()
    return []


@pytest.mark.parametrize("slip", SLIPS)
def test_a_slip_of_units_is_refused_and_a_key_takes_it_as_it_is(slip):
    change, printed = SLIPS[slip]
    lines = [line for line in found_in(change) if printed in line]
    assert len(lines) == 1
    assert "not usual of rock" in lines[0]
    assert "study.unusual_values: allow takes it as it is" in lines[0]
    # it may contradict another key all the same
    assert not any("not usual" in line for line in found_in(change, unusual_values="allow"))


def test_rocks_that_are_not_studied_may_be_what_they_are():
    tuff = {"title": "T", "youngs_modulus_GPa": 1e-9, "poisson_ratio": 0.2, "jrc": 8,
            "compressive_strength_MPa": 1, "max_normal_stress_MPa": 1, "levels": {}}  # fmt: skip
    study_of({"rocks": {"tuff": tuff}})
    with pytest.raises(ConfigurationError, match="not usual"):
        study_of({"rocks": {"tuff": tuff}, "study": {"rocks": ["tuff"]}})


@pytest.mark.parametrize(
    ("change", "printed"),
    [
        ({"rock": jc.Rock(55.0, 0.2, 165e6)}, "youngs_modulus = 55.0 Pa: not usual"),
        ({"spacing": 0.25}, "spacing = 0.25 m: not usual"),
        ({"max_normal_stress": 5}, "is 5 MPa meant, 5e+06 Pa?"),
        ({"max_normal_stress": 5e12}, "is 5e+06 Pa meant?"),
        ({"max_normal_stress": [5e6, 0.0, 8]}, "max_normal_stress = 8 Pa: not usual"),
        ({"seating_stress": 0.5}, "seating_stress = 0.5 Pa: not usual"),
        ({"numerics": jc.Numerics(displacement_step=12.5)}, "displacement_step = 12.5 m: not"),
        ({"choices": jc.Choices(largest_radius=20.0)}, "largest_radius = 20.0 m: not usual"),
    ],
)
def test_the_library_refuses_a_slip_of_units_too(change, printed):
    walls = [jc.wall_pair(8.0, (6, 6), 0.25e-3, seed) for seed in range(2)]
    for close in (
        lambda **stated: jc.simulate(*walls[0], **{"seating_stress": 0.0} | stated),
        lambda **stated: jc.choose_effects(walls, **stated),
    ):
        with pytest.raises(jc.InputError, match="unusual_values=True") as error:
            close(**USUAL | change)
        assert printed in str(error.value)


@pytest.mark.parametrize("given", [{"roll_off": 3.0}, {"mismatch_wavelength": 1.0}])
def test_wavelengths_in_another_unit_are_refused(given):
    settings = {"shape": (6, 6), "spacing": 0.25e-3, "seed": 1} | given
    with pytest.raises(jc.InputError, match=r"= \d.0 m: not usual .*unusual_values=True"):
        jc.wall_pair(8.0, **settings)
    assert jc.wall_pair(8.0, **settings, unusual_values=True)[0].shape == (6, 6)
    name, value = next(iter(given.items()))
    slip = {"surface": {f"{name}_mm": 1e3 * value}}
    assert any("not usual" in line for line in found_in(slip))
    assert not found_in(slip, unusual_values="allow")

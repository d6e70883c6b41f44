"""What kinds of numbers walls and levels may be, at every public function."""

import numpy as np
import pytest

import jointclosure as jc
from tests.joints import DOLERITE, SPACING

LEVELS = [70.0, 78.0, 85.0]


def simulate(upper, lower, **change):
    stated = {"spacing": SPACING, "rock": DOLERITE, "max_normal_stress": 1e6, "cycles": 1}
    return jc.simulate(upper, lower, **stated | change)


def equilibrium(upper, lower, **change):
    stated = {"spacing": SPACING, "rock": DOLERITE, "closure": 1e-4}
    return jc.equilibrium(upper, lower, **stated | change)


@pytest.fixture(params=[simulate, equilibrium], ids=lambda function: function.__name__)
def close(request):
    return request.param


@pytest.fixture(scope="module")
def walls():
    """Heights in multiples of 2^-16 m, which every type of float holds exactly."""
    pair = jc.wall_pair(8.0, (9, 11), SPACING, seed=4)
    return [np.round(wall * 2.0**16) / 2.0**16 for wall in pair]


FORMS = {
    "float32": lambda wall: wall.astype(np.float32),
    "float16": lambda wall: wall.astype(np.float16),
    "long double": lambda wall: wall.astype(np.longdouble),
    "big-endian": lambda wall: wall.astype(">f8"),
    "Fortran order": np.asfortranarray,
    "not contiguous": lambda wall: np.repeat(np.repeat(wall, 2, 0), 3, 1)[::2, ::3],
    "reversed views": lambda wall: wall[::-1, ::-1].copy()[::-1, ::-1],
    "read-only": lambda wall: np.frombuffer(wall.tobytes()).reshape(wall.shape),
    "lists": lambda wall: wall.tolist(),
    "masked nowhere": np.ma.masked_array,
}


@pytest.mark.parametrize("form", FORMS)
def test_a_form_that_holds_the_heights_gives_the_same_joint(close, walls, form):
    given = [FORMS[form](wall) for wall in walls]
    for wall, back in zip(walls, given, strict=True):
        np.testing.assert_array_equal(np.asarray(back, dtype=float), wall)
    assert close(*given).identical(close(*walls))


def test_single_precision_is_promoted_and_its_lost_digits_stay_lost(close):
    walls = jc.wall_pair(8.0, (9, 11), SPACING, seed=4)
    single = [wall.astype(np.float32) for wall in walls]
    found = close(*single)
    assert found.identical(close(*(wall.astype(float) for wall in single)))
    assert not found.identical(close(*walls))
    for variable in found.data_vars.values():
        assert variable.dtype != np.float32


def test_numbers_of_single_precision_do_not_make_the_answer_so(walls):
    numbers = dict(zip(jc.Rock._fields, DOLERITE, strict=True))
    single = {name: np.float32(value) for name, value in numbers.items()}
    double = {name: float(value) for name, value in single.items()}
    stated = []
    for rock, real in ((single, np.float32), (double, lambda value: float(np.float32(value)))):
        numerics = jc.Numerics(*(real(step) for step in (12.5e-6, 5e-6, 6.25e-6, 2.5e-6)))
        choices = jc.Choices(base_radius_in_cells=real(0.3), largest_radius=real(0.02))
        stated.append(
            {
                "spacing": real(SPACING),
                "rock": jc.Rock(**rock),
                "numerics": numerics,
                "choices": choices,
            }
        )
    for closed in (
        [
            simulate(*walls, max_normal_stress=np.float32(1e6), **stated[0]),
            simulate(*walls, **stated[1]),
        ],
        [equilibrium(*walls, closure=2.0**-13, **each) for each in stated],
    ):
        assert closed[0].identical(closed[1])
        assert all(v.dtype != np.float32 for v in closed[0].variables.values())


REFUSED = {
    "complex": (np.zeros((4, 4), complex), "values of type complex128"),
    "object": (np.zeros((4, 4), object), "values of type object"),
    "boolean": (np.zeros((4, 4), bool), "values of type bool"),
    "text": (np.full((4, 4), "0.1"), "values of type <U3"),
    "dates": (np.zeros((4, 4), "M8[s]"), r"values of type datetime64\[s\]"),
    "masked": (np.ma.masked_array(np.zeros((4, 4)), np.eye(4)), "masked values"),
    "ragged": ([[1.0, 2.0], [3.0]], "is not an array"),
    "nothing": (None, "values of type object"),
    "one-dimensional": (np.zeros(4), "shape"),
    "empty": (np.zeros((0, 4)), "shape"),
    "too large a height": (np.full((4, 4), 1e16), "a height of 1e[+]16 m"),
}


@pytest.mark.parametrize("side", ["upper", "lower"])
@pytest.mark.parametrize("kind", REFUSED)
def test_what_is_no_wall_of_real_heights_is_refused_by_name(close, kind, side):
    wall, printed = REFUSED[kind]
    pair = (wall, np.zeros((4, 4))) if side == "upper" else (np.zeros((4, 4)), wall)
    with pytest.raises(jc.InputError, match=f"{side}: .*{printed}"):
        close(*pair)


@pytest.mark.parametrize("side", ["upper", "lower"])
@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
@pytest.mark.parametrize("kind", [np.float16, np.float32, np.float64])
def test_one_bad_height_deep_inside_a_wall_is_found_and_said_where(close, kind, value, side):
    pair = {"upper": np.zeros((60, 70), kind), "lower": np.zeros((60, 70), kind)}
    pair[side][41, 37] = value
    printed = rf"{side}: 1 values are not finite, the first at \(y, x\) = \(41, 37\)"
    with pytest.raises(jc.InputError, match=printed):
        close(**pair)


def test_denormal_heights_are_as_good_as_flat(close):
    flat = np.zeros((6, 7))
    tiny = 5e-324 * np.random.default_rng(3).integers(0, 9, flat.shape)
    kept = {"unusual_values": True}  # flat walls carry any stress
    found, expected = close(tiny, flat, **kept), close(flat, flat, **kept)
    assert int(found.status) == int(expected.status)
    name = "max_closure" if close is simulate else "normal_stress"
    assert np.isfinite(found[name]).all()
    np.testing.assert_allclose(found[name], expected[name], rtol=1e-8)


@pytest.mark.parametrize("spacing", [1e-30, 1e30, float("nan")])
def test_a_spacing_whose_powers_do_not_fit_is_refused(close, spacing):
    with pytest.raises(jc.InputError, match="spacing = "):
        close(np.zeros((4, 4)), np.zeros((4, 4)), spacing=spacing)


@pytest.mark.parametrize("name", ["displacement_step", "later_displacement_step"])
def test_a_step_that_rounding_of_the_heights_would_swallow_is_refused(name):
    wall = np.zeros((4, 4))
    wall[1, 1] = 1e6
    numerics = jc.Numerics()._replace(
        breakage_step=1e-12, later_breakage_step=1e-12, **{name: 2e-11}
    )
    with pytest.raises(jc.InputError, match=f"{name} = 2e-11 m: must be at least"):
        simulate(wall, 0.0 * wall, numerics=numerics, unusual_values=True)


@pytest.mark.parametrize(
    ("settings", "field", "value"),
    [
        (jc.Numerics, "idle_interaction", 2),
        (jc.Numerics, "displacement_step", -1.0),
        (jc.Numerics, "breakage", "x"),
        (jc.Choices, "concave", "x"),
    ],
)
def test_settings_are_checked_when_they_are_made(settings, field, value):
    with pytest.raises(jc.InputError, match=f"{field} = {value!r}"):
        settings(**{field: value})


@pytest.mark.parametrize("closure", [float("nan"), 1e300, True])
def test_a_closure_that_is_no_length_is_refused(closure):
    with pytest.raises(jc.InputError, match="closure = "):
        equilibrium(np.zeros((4, 4)), np.zeros((4, 4)), closure=closure)


def test_a_closure_given_in_millimetres_is_refused_unless_it_is_meant(walls):
    with pytest.raises(jc.InputError, match=r"closure = 0\.2 m: not usual of this joint"):
        equilibrium(*walls, closure=0.2)
    with pytest.raises(jc.InputError, match=r"closure = 0\.001 m: takes a stress of"):
        equilibrium(*walls, closure=1e-3)
    assert int(equilibrium(*walls, closure=0.2e-3).status) == 0
    meant = equilibrium(*walls, closure=0.2, unusual_values=True)
    assert float(meant.normal_stress) > 1e11


@pytest.mark.parametrize("name", ["levels", "means", "standard_deviations"])
@pytest.mark.parametrize(
    ("values", "printed"),
    [
        (np.array([1, 2, 3], complex), "values of type complex128"),
        (np.ma.masked_array([1.0, 2.0, 3.0], [False, True, False]), "masked values"),
        ([1.0, float("nan"), 3.0], r"1 values are not finite, the first at \(1\)"),
    ],
)
def test_statistics_of_what_is_no_real_number_are_refused_by_name(name, values, printed):
    good = {"levels": LEVELS, "means": [3.0, 2.0, 1.0], "standard_deviations": [0.1] * 3}
    with pytest.raises(jc.InputError, match=f"{name}: .*{printed}"):
        jc.indifference_interval(**good | {name: values}, samples=20)


@pytest.mark.parametrize("kind", [np.float16, np.float32, np.longdouble])
def test_walls_do_not_depend_on_the_type_of_the_numbers_they_are_made_of(kind):
    given = {"jrc": kind(8), "spacing": kind(2.0**-12), "hurst": kind(0.75), "seed": np.int64(3)}
    plain = {"jrc": 8.0, "spacing": 2.0**-12, "hurst": 0.75, "seed": 3}
    for one, other in zip(
        jc.wall_pair(shape=(9, 9), **given), jc.wall_pair(shape=(9, 9), **plain), strict=True
    ):
        assert one.dtype == np.float64
        np.testing.assert_array_equal(one, other)

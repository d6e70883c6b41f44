"""What walls and numbers may be, at every function that closes a joint."""

import warnings

import numpy as np
import pandas as pd
import pytest
import xarray as xr

import jointclosure as jc
from jointclosure.joint.wall_checks import checked_walls
from jointclosure.walls.plausibility import doubts
from tests import joints
from tests.joints import DOLERITE, ELASTIC, SPACING

SHAPE = (9, 9)  # square: a transposed wall would fit
X = SPACING * np.arange(9)
FLAT = np.zeros((4, 4))


def simulate(upper, lower, **change):
    return joints.closed((upper, lower), 1e6, **{"cycles": 1} | change)


def equilibrium(upper, lower, **change):
    return joints.balanced((upper, lower), **{"closure": 1e-4} | change)


@pytest.fixture(params=[simulate, equilibrium], ids=lambda function: function.__name__)
def close(request):
    return request.param


@pytest.fixture(scope="module")
def walls():
    """Heights in multiples of 2^-16 m, which every type of float holds exactly."""
    return [np.round(wall * 2.0**16) / 2.0**16 for wall in jc.wall_pair(8.0, SHAPE, SPACING, 4)]


FORMS = {
    "float32": lambda wall: wall.astype(np.float32),
    "float16": lambda wall: wall.astype(np.float16),
    "big-endian": lambda wall: wall.astype(">f8"),
    "Fortran order": np.asfortranarray,
    "reversed views": lambda wall: wall[::-1, ::-1].copy()[::-1, ::-1],
    "read-only": lambda wall: np.frombuffer(wall.tobytes()).reshape(wall.shape),
    "lists": lambda wall: wall.tolist(),
    "masked nowhere": np.ma.masked_array,
}


@pytest.mark.parametrize("form", FORMS)
def test_a_form_that_holds_the_heights_gives_the_same_joint(close, walls, form):
    given = [FORMS[form](wall) for wall in walls]
    np.testing.assert_array_equal(np.asarray(given, dtype=float), walls)
    assert close(*given).identical(close(*walls))


REFUSED = {
    "complex": (FLAT.astype(complex), "values of type complex128"),
    "text": (np.full((4, 4), "0.1"), "values of type <U3"),
    "masked": (np.ma.masked_array(FLAT, np.eye(4)), "masked values"),
    "ragged": ([[1.0, 2.0], [3.0]], "is not an array"),
    "nothing": (None, "values of type object"),
    "empty": (np.zeros((0, 4)), "shape"),
    "too large a height": (np.full((4, 4), 1e16), "a height of 1e[+]16 m"),
    "dataset": (xr.Dataset({"height": (("y", "x"), FLAT)}), "is an xarray.Dataset of height; must"),
    **{
        f"{value} in {kind.__name__}": (
            np.where(np.arange(4200).reshape(60, 70) == 41 * 70 + 37, kind(value), kind(0.0)),
            r"1 values are not finite, the first at \(y, x\) = \(41, 37\)",
        )
        for value, kind in ((np.nan, np.float64), (-np.inf, np.float16))
    },
}


@pytest.mark.parametrize("side", [0, 1])
@pytest.mark.parametrize("kind", REFUSED)
def test_what_is_no_wall_of_real_heights_is_refused_by_name(close, kind, side):
    wall, printed = REFUSED[kind]
    pair = [FLAT, FLAT]
    pair[side] = wall
    with pytest.raises(jc.InputError, match=f"{('upper', 'lower')[side]}: .*{printed}"):
        close(*pair)


@pytest.mark.parametrize("name", ["displacement_step", "later_displacement_step"])
def test_a_step_that_rounding_of_the_heights_would_swallow_is_refused(name):
    wall = FLAT.copy()
    wall[1, 1] = 1e6
    steps = {"breakage_step": 1e-12, "later_breakage_step": 1e-12, name: 2e-11}
    with pytest.raises(jc.InputError, match=f"{name} = 2e-11 m: must be at least"):
        simulate(wall, FLAT, unusual_values=True, **steps)


def test_a_closure_that_is_no_length_or_in_millimetres_is_refused_unless_it_is_meant():
    for closure in (float("nan"), 1e300, True):
        with pytest.raises(jc.InputError, match="closure = "):
            equilibrium(FLAT, FLAT, closure=closure)
    walls = jc.wall_pair(8.0, (9, 11), SPACING, seed=4)
    with pytest.raises(jc.InputError, match=r"closure = 0\.2 m: not usual of this joint"):
        equilibrium(*walls, closure=0.2)
    with pytest.raises(jc.InputError, match=r"closure = 0\.001 m: takes a stress of"):
        equilibrium(*walls, closure=1e-3)
    assert int(equilibrium(*walls, closure=0.2e-3).status) == 0
    meant = equilibrium(*walls, closure=0.2, unusual_values=True)
    assert float(meant.normal_stress) > 1e11


def named(wall, dims=("y", "x"), **coords):
    return xr.DataArray(wall, dims=dims, coords=coords)


def test_a_transposed_wall_is_turned_by_the_names_of_its_dimensions(walls):
    upper, lower = walls
    plain = simulate(upper, lower)
    assert not plain.equals(simulate(upper, lower.T))  # it matters
    for given in (
        (named(upper), named(lower.T, ("x", "y"))),
        (named(upper.T, ("x", "y")), named(lower.T, ("x", "y"))),
        (upper, named(lower.T, ("x", "y"))),
        (named(upper, ("row", "column")), named(lower.T, ("column", "row"))),
        (named(upper, x=X), named(lower, x=X * (1.0 + 1e-9))),
    ):
        assert simulate(*given).identical(plain)


@pytest.mark.parametrize(
    ("places", "units"),
    [(SPACING, None), (-SPACING, None), (1e3 * SPACING, "mm"), (1e6 * SPACING, "micrometre")],
)
def test_coordinates_of_the_spacing_are_those_of_the_walls(places, units, walls):
    x = ("x", 7.0 + places * np.arange(9), {} if units is None else {"units": units})
    checked = checked_walls(named(walls[0], x=x), walls[1], SPACING)
    np.testing.assert_array_equal(checked[0], walls[0])
    checked_walls(named(walls[0], x=np.arange(9), y=np.arange(1, 10)), walls[1], SPACING)


@pytest.mark.parametrize(
    ("upper", "lower", "printed"),
    [
        ({"x": X}, {"dims": ("y", "z")}, r"dimensions \('y', 'x'\) and \('y', 'z'\)"),
        *(({"x": X}, {"x": x}, "coordinates x differ") for x in (X + SPACING, X[::-1], 2.0 * X)),
        ({"x": 1e3 * X}, {}, "its coordinate x has steps of 0.25 m, and spacing"),
        ({}, {"x": SPACING * np.arange(9) ** 2}, "steps of 0.00025 to 0.00375 m"),
        ({}, {"x": ("x", X, {"units": "cm"})}, "coordinate x: units = 'cm'"),
    ],
)
def test_walls_of_other_dimensions_or_at_other_places_are_refused_by_name(
    close, upper, lower, printed, walls
):
    given = [named(wall, **about) for wall, about in zip(walls, (upper, lower), strict=True)]
    with pytest.raises(jc.InputError, match=printed):
        close(*given)


def test_a_data_frame_is_what_its_labels_say(walls):
    upper, lower = walls
    letters, turned = (
        list("abcdefghi"),
        pd.DataFrame(lower.T, X, X).rename_axis(index="x", columns="y"),
    )
    for given in (
        [pd.DataFrame(wall) for wall in walls],
        (pd.DataFrame(upper, X, X), turned),
        [pd.DataFrame(wall, letters) for wall in walls],
    ):
        np.testing.assert_array_equal(checked_walls(*given, SPACING), walls)
    with pytest.raises(jc.InputError, match="their labels y differ"):
        checked_walls(pd.DataFrame(upper, letters), pd.DataFrame(lower, letters[::-1]), SPACING)


def mates():
    return jc.wall_pair(8.0, (24, 24), SPACING, seed=3, correlation=0.95, roll_off=None)


@pytest.mark.parametrize(
    ("change", "printed"),
    [
        (lambda upper, lower: (-upper, lower), ["the walls are alike"]),
        (lambda upper, lower: (np.flip(upper, 0), lower), ["reversed along y"]),
        (lambda upper, lower: (np.flip(upper, 1), lower), ["reversed along x"]),
        (lambda upper, lower: (1e3 * upper, 1e-4 * lower), ["rms slope"] * 2),
    ],
)
def test_slips_of_units_or_orientation_are_reported(change, printed):
    found = doubts(*change(*mates()), SPACING)
    assert [text in line for text, line in zip(printed, found, strict=True)] == [True] * len(found)


def test_symmetric_walls_that_fit_as_given_are_not_said_to_be_reversed():
    drawn = jc.wall_pair(8.0, (40, 40), SPACING, seed=3, correlation=0.95, roll_off=None)
    upper, lower = (wall + np.flip(wall, 0) for wall in drawn)
    assert doubts(upper, lower, SPACING) == []


def test_lenses_that_are_alike_are_no_walls_of_a_joint():
    lens = joints.bump((24, 24), 0.05)
    assert doubts(lens, lens, SPACING) == []


def test_simulate_warns_once_unless_told_that_values_are_unusual():
    upper, lower = mates()
    stated = {"spacing": SPACING, "rock": DOLERITE, "max_normal_stress": 1e6, "cycles": 1}
    stated["effects"] = ELASTIC
    with pytest.warns(UserWarning, match="alike") as heard:
        jc.simulate(-upper, lower, **stated)
    assert [warning.filename for warning in heard] == [__file__]
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        jc.simulate(-upper, lower, unusual_values=True, **stated)
        jc.simulate(upper, lower, **stated)


def test_walls_have_at_least_three_cells_one_way():
    for shape in ((1, 3), (3, 1), (3, 3)):
        assert checked_walls(np.zeros(shape), np.zeros(shape), SPACING)[0].shape == shape
    with pytest.raises(jc.InputError, match="at least 3 cells"):
        checked_walls(np.zeros((2, 2)), np.zeros((2, 2)), SPACING)


def test_both_walls_have_the_same_shape():
    with pytest.raises(jc.InputError, match=r"shapes .* must be equal"):
        checked_walls(np.zeros((3, 4)), np.zeros((4, 3)), SPACING)


def test_walls_have_the_spacing_of_their_coordinates():
    checked_walls(named(np.zeros(SHAPE), x=1.0009 * X), np.zeros(SHAPE), SPACING)
    with pytest.raises(jc.InputError, match="its coordinate x has steps"):
        checked_walls(named(np.zeros(SHAPE), x=1.0011 * X), np.zeros(SHAPE), SPACING)

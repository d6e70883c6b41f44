"""Walls with names: an `xarray.DataArray` is what its dimensions and coordinates say."""

import numpy as np
import pandas as pd
import pytest
import xarray as xr

import jointclosure as jc
from jointclosure.joint.given_walls import checked_walls
from tests.joints import DOLERITE, SPACING

SHAPE = (9, 9)  # square: a transposed wall would fit


def closed(upper, lower):
    return jc.simulate(
        upper, lower, spacing=SPACING, rock=DOLERITE, max_normal_stress=1e6, cycles=1
    )


@pytest.fixture(scope="module")
def walls():
    return jc.wall_pair(8.0, SHAPE, SPACING, seed=4)


def named(wall, dims=("y", "x"), **coords):
    return xr.DataArray(wall, dims=dims, coords=coords)


def test_a_transposed_wall_is_turned_by_the_names_of_its_dimensions(walls):
    upper, lower = walls
    plain = closed(upper, lower)
    assert not plain.equals(closed(upper, lower.T))  # it matters
    for given in (
        (named(upper), named(lower.T, ("x", "y"))),
        (named(upper.T, ("x", "y")), named(lower.T, ("x", "y"))),
        (upper, named(lower.T, ("x", "y"))),
        (named(upper, ("row", "column")), named(lower.T, ("column", "row"))),
    ):
        assert closed(*given).identical(plain)


def test_walls_of_unlike_dimensions_are_refused_by_name(walls):
    with pytest.raises(jc.InputError, match=r"dimensions \('y', 'x'\) and \('y', 'z'\)"):
        closed(named(walls[0]), named(walls[1], ("y", "z")))


def test_walls_at_other_places_are_refused_by_the_coordinate(walls):
    x = SPACING * np.arange(9)
    same = closed(named(walls[0], x=x), named(walls[1], x=x * (1.0 + 1e-9)))
    assert same.identical(closed(*walls))
    for other in (x + SPACING, x[::-1], 2.0 * x):
        with pytest.raises(jc.InputError, match="coordinates x differ"):
            closed(named(walls[0], x=x), named(walls[1], x=other))


def test_a_dataset_is_no_wall_and_its_variables_are_named(walls):
    upper, lower = walls
    with pytest.raises(jc.InputError, match=r"upper: is an xarray.Dataset of height; must be"):
        closed(xr.Dataset({"height": (("y", "x"), upper)}), lower)
    with pytest.raises(jc.InputError, match=r"lower: is an xarray.Dataset"):
        closed(upper, xr.Dataset({"height": (("y", "x"), lower)}))


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
    ("x", "printed"),
    [
        (1e3 * SPACING * np.arange(9), "its coordinate x has steps of 0.25 m, and spacing"),
        (SPACING * np.arange(9) ** 2, "steps of 0.00025 to 0.00375 m"),
        (("x", SPACING * np.arange(9), {"units": "inch"}), "coordinate x: units = 'inch'"),
    ],
)
def test_coordinates_that_contradict_the_spacing_are_refused(x, printed, walls):
    for pair in ((named(walls[0], x=x), walls[1]), (walls[0], named(walls[1], x=x))):
        with pytest.raises(jc.InputError, match=printed):
            closed(*pair)
        with pytest.raises(jc.InputError, match=printed):
            jc.equilibrium(*pair, spacing=SPACING, rock=DOLERITE, closure=1e-6)


def labelled(wall, **axes):
    return pd.DataFrame(wall).rename_axis(**axes)


def test_a_data_frame_is_what_its_labels_say(walls):
    upper, lower = walls
    x = SPACING * np.arange(9)
    turned = labelled(pd.DataFrame(lower.T, x, x), index="x", columns="y")
    for given in (
        (labelled(upper), labelled(lower)),
        (pd.DataFrame(upper, x, x), turned),
        (pd.DataFrame(upper, list("abcdefghi")), pd.DataFrame(lower, list("abcdefghi"))),
    ):
        np.testing.assert_array_equal(checked_walls(*given, SPACING), walls)
    shifted = pd.DataFrame(lower, x + SPACING, x)
    with pytest.raises(jc.InputError, match="their coordinates y differ"):
        checked_walls(pd.DataFrame(upper, x, x), shifted, SPACING)
    with pytest.raises(jc.InputError, match="their labels y differ"):
        checked_walls(
            pd.DataFrame(upper, list("abcdefghi")), pd.DataFrame(lower, list("ihgfedcba"))
        )
    with pytest.raises(jc.InputError, match=r"steps of 0.00025 m, and spacing = 0.0005 m"):
        checked_walls(pd.DataFrame(upper, x, x), lower, 2.0 * SPACING)

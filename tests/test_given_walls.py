"""Walls with names: an `xarray.DataArray` is what its dimensions and coordinates say."""

import numpy as np
import pytest
import xarray as xr

import jointclosure as jc
from tests.conftest import DOLERITE, SPACING

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

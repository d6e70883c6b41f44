"""Datasets of the public functions: indices, coordinates, attributes."""

import json

import numpy as np
import pytest
import xarray as xr

import jointclosure as jc
from tests.joints import SPACING

LOAD = {"rock": "granite", "max_normal_stress": 2e6, "cycles": 2}
GRANITE = jc.Rock(73e9, 0.25, 173e6)


def scanned(wall, folder):
    x = SPACING * np.arange(wall.shape[1])
    np.savez(folder / "wall.npz", z=wall, x=x, y=x)
    stated = {
        "units": "m",
        "orientation": "towards",
        "single": True,
        "numerics": jc.Numerics(),
    } | LOAD
    return jc.close(folder / "wall.npz", "flat", **stated).history


@pytest.fixture(scope="module")
def datasets(tmp_path_factory):
    walls = jc.wall_pair(8.0, (24, 24), SPACING, seed=1)
    stated = {"spacing": SPACING, **LOAD}
    return {
        "simulate": jc.simulate(*walls, flow=True, snapshots=[1e6], **stated),
        "simulate_ensemble": jc.simulate_ensemble([walls], workers=1, **stated),
        "close": scanned(walls[0], tmp_path_factory.mktemp("scans")),
        "equilibrium": jc.equilibrium(*walls, spacing=SPACING, rock="granite", closure=1e-5),
    }


NAMES = ["simulate", "simulate_ensemble", "close", "equilibrium"]


@pytest.mark.parametrize("name", NAMES)
def test_a_coordinate_with_the_name_of_a_dimension_is_its_index(datasets, name):
    data = datasets[name]
    for dimension in set(data.dims) & set(data.coords):
        assert data[dimension].dims == (dimension,)
    if name != "equilibrium":
        assert data.indexes["cycle"].tolist() == [1, 2]
        for number in (1, 2):
            cycle = data.max_closure.isel(cycle=number - 1)
            xr.testing.assert_identical(data.max_closure.sel(cycle=number), cycle)


@pytest.mark.parametrize("name", NAMES)
def test_attributes_state_rock_spacing_and_conventions_and_outlive_a_file(datasets, name, tmp_path):
    data = datasets[name].drop_vars("error", errors="ignore")
    data.to_netcdf(tmp_path / "data.nc")
    attributes = xr.load_dataset(tmp_path / "data.nc").attrs
    assert attributes["Conventions"].startswith("CF-")
    assert attributes["spacing_m"] == pytest.approx(SPACING)
    rock = json.loads(attributes["rock"])
    assert rock["name"] == "granite"
    assert rock["upper"] == rock["lower"]
    assert rock["upper"]["youngs_modulus_GPa"] == 1e-9 * GRANITE.youngs_modulus
    assert json.loads(attributes["numerics"]) == jc.Numerics()._asdict()
    if name != "equilibrium":
        assert attributes["max_normal_stress_Pa"] == 2e6


def test_the_cycle_of_a_step_is_beside_its_branch(datasets):
    data = datasets["simulate"]
    assert data.load_cycle.dims == data.branch.dims == ("step",)
    assert set(data.load_cycle.values.tolist()) == {1, 2}
    highest = data.normal_stress.groupby("load_cycle").max()
    np.testing.assert_allclose(highest, 2e6, rtol=1e-2)

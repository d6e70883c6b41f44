"""Datasets of the public functions: indices, coordinates, attributes."""

import json

import pytest
import xarray as xr

import jointclosure as jc
from jointclosure.walls.gridding import Scan
from tests.joints import SPACING

LOAD = {"rock": "granite", "max_normal_stress": 2e6, "cycles": 2}


GRANITE = jc.Rock(73e9, 0.25, 173e6)


@pytest.fixture(scope="module")
def datasets():
    walls = jc.wall_pair(8.0, (24, 24), SPACING, seed=1)
    stated = {"spacing": SPACING, **LOAD}
    scan = Scan(walls[0], (SPACING, SPACING))
    single = {"orientation": "towards", "single": True, "numerics": jc.Numerics()}
    return {
        "simulate": jc.simulate(*walls, flow=True, snapshots=[1e6], **stated),
        "simulate_ensemble": jc.simulate_ensemble([walls], workers=1, **stated),
        "close": jc.close(scan, "flat", **single, **LOAD).history,
        "equilibrium": jc.equilibrium(*walls, spacing=SPACING, rock="granite", closure=1e-5),
    }


FUNCTIONS = pytest.mark.parametrize(
    "name", ["simulate", "simulate_ensemble", "close", "equilibrium"]
)


@FUNCTIONS
def test_coordinates_are_indices(datasets, name):
    data = datasets[name]
    for dimension in set(data.dims) & set(data.coords):
        assert data[dimension].dims == (dimension,)
    if name != "equilibrium":
        assert data.indexes["cycle"].tolist() == [1, 2]
        for number in (1, 2):
            cycle = data.max_closure.isel(cycle=number - 1)
            xr.testing.assert_identical(data.max_closure.sel(cycle=number), cycle)


@FUNCTIONS
def test_attributes_in_a_file_state_the_joint(datasets, name, tmp_path):
    datasets[name].drop_vars("error", errors="ignore").to_netcdf(tmp_path / "data.nc")
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

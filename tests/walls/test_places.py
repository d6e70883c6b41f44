"""Statements of the places of heights give one wall where they agree, or are refused by name."""

from unittest.mock import patch

import netCDF4
import numpy as np
import pytest
import scipy.io
import xarray as xr
from hypothesis import assume, given
from hypothesis import strategies as st

import jointclosure as jc
from jointclosure.walls.scans import contents, read_scan
from tests.walls.test_formats import RANDOM

SIZES = {"m": 1e-3, "mm": 1.0, "um": 1e3}
WALL = 0.3 * np.random.default_rng(2).normal(size=(9, 12))
STEPS = 0.3, 0.4  # along y and x [mm]


def write(path, arrays, dimensions=("y", "x")):
    """Write arrays by name in the form of a file's suffix, and the heights ``Z`` among them."""
    if path.suffix == ".npz":
        np.savez(path, **arrays)
    elif path.suffix == ".mat":
        scipy.io.savemat(path, arrays)
    else:
        variables = {}
        for name, values in arrays.items():
            values = np.asarray(values)
            along = dimensions[: values.ndim]
            if values.ndim == 1:
                along = (dimensions[name[0].lower() == "x"],)
            variables[name] = (along, values)
        xr.Dataset(variables).to_netcdf(path, engine="netcdf4")


def statements(steps, shape):
    """Forms in which a file states the spacing (dy, dx) [mm] of heights of a shape (y, x)."""
    y, x = (5.0 + step * np.arange(n) for step, n in zip(steps, shape, strict=True))
    forms = {
        "numbers": {"dy": steps[0], "dx": steps[1]},
        "vectors": {"y": y, "x": x},
        "matrices": {"Y": y[:, None] + 0.0 * x, "X": x + 0.0 * y[:, None]},
    }
    if steps[0] == steps[1]:
        forms |= {"spacing": {"spacing": steps[0]}, "h": {"h": steps[0]}}
    return forms


@st.composite
def stated(draw):
    """Suffix, steps, and forms that state them, each with its unit."""
    steps = draw(st.sampled_from([(0.3, 0.3), STEPS, (1.0 / 3.0, 1.0 / 3.0)]))
    forms = statements(steps, WALL.shape)
    chosen = draw(st.lists(st.sampled_from(sorted(forms)), min_size=1, unique=True))
    units = [draw(st.sampled_from(sorted(SIZES))) for _ in chosen]
    suffix = draw(st.sampled_from([".npz", ".mat", ".nc"]))
    return suffix, steps, dict(zip(chosen, units, strict=True))


def named(forms, units, scale=None):
    """Arrays of forms with their units in their names, one form scaled by a factor."""
    return {
        f"{name}_{unit}": values * SIZES[unit] * (scale or {}).get(form, 1.0)
        for form, unit in units.items()
        for name, values in forms[form].items()
    }


@RANDOM
@given(stated(), st.booleans(), st.booleans())
def test_statements_that_agree_in_any_unit_are_one_wall(tmp_path, stated, argument, falling):
    suffix, steps, units = stated
    path, heights, given = tmp_path / f"a{suffix}", WALL, {}
    forms = statements(steps, WALL.shape)
    if falling and set(units) & {"vectors", "matrices"}:
        heights = WALL[::-1]
        forms["vectors"]["y"] = forms["vectors"]["y"][::-1]
        forms["matrices"]["Y"] = forms["matrices"]["Y"][::-1]
    if argument and steps[0] == steps[1]:
        given["scan_spacing"] = 1e-3 * steps[0]
    write(path, {"Z_um": 1e3 * heights} | named(forms, units))
    scan = read_scan(path, **given)
    np.testing.assert_allclose(scan.heights, 1e-3 * WALL, rtol=1e-9)
    assert scan.spacing == pytest.approx([1e-3 * step for step in steps], rel=1e-6)
    if set(units) & {"vectors", "matrices"}:
        assert scan.origin == pytest.approx((5e-3, 5e-3), rel=1e-6)


@RANDOM
@given(stated(), st.sampled_from([0.5, 0.9, 1.02, 2.0, 1e3]), st.data())
def test_a_statement_that_differs_is_refused_by_name(tmp_path, stated, factor, data):
    suffix, steps, units = stated
    path, given = tmp_path / f"a{suffix}", {}
    form = data.draw(st.sampled_from(sorted(units)))
    arrays = named(statements(steps, WALL.shape), units, {form: factor})
    if len(units) == 1:
        assume(steps[0] == steps[1])
        given["scan_spacing"] = 1e-3 * steps[0]
    write(path, {"Z_um": 1e3 * WALL} | arrays)
    with pytest.raises(jc.InputError) as error:
        read_scan(path, **given)
    wrong = [name for name in arrays if name.split("_")[0] in statements(steps, WALL.shape)[form]]
    words = str(error.value).replace(",", " ").split()
    assert given or set(wrong) & set(words)
    assert not given or f"spacing = {steps[0]:g} mm: the file states" in str(error.value)


@pytest.mark.parametrize("suffix", [".npz", ".mat"])
def test_names_without_units_are_in_those_that_are_stated(suffix, tmp_path):
    y, x = (step * np.arange(n) for step, n in zip(STEPS, WALL.shape, strict=True))
    write(tmp_path / f"a{suffix}", {"Z": WALL, "x": x, "y": y, "dx": 0.4})
    assert read_scan(tmp_path / f"a{suffix}", units="mm").spacing == pytest.approx((3e-4, 4e-4))
    write(tmp_path / f"b{suffix}", {"Z": WALL, "x": x, "y": y, "dx_um": 400.0})
    with pytest.raises(jc.InputError, match=r"x 0.3 x 0.4; dx_um 400 um; must be the same"):
        read_scan(tmp_path / f"b{suffix}", units="mm")


X, Y = 0.4 * np.arange(12), 0.3 * np.arange(9)
FOLDED, ORDER = np.abs(X - 2.0), [0, 2, 1, 4, 3, 5, 6, 7, 9, 8, 11, 10]
FILES = {
    "dx alone": ({"dx": 0.4}, {}, (0.4, 0.4)),
    "one coordinate": ({"x": X}, {}, "does not state the spacing of its grid along y:"),
    "one coordinate and a spacing": ({"x": X}, {"scan_spacing": 4e-4}, (0.4, 0.4)),
    "one coordinate and dy": ({"x": X, "dy": 0.3}, {}, (0.3, 0.4)),
    "one uneven coordinate": ({"x": X**2}, {}, "x: must be evenly spaced"),
    "returning coordinates": ({"x": FOLDED, "y": Y}, {}, "places have several heights"),
    "places of another array": (
        {"x": X[1:], "y": Y}, {}, r"x \((1 x )?11\): must be places of Z \(9 x",
    ),
    "two places": (
        {"x": X, "y": Y, "X": X + 0.0 * Y[:, None] + 1.0}, {},
        "x 0 to 4.4, X 1 to 5.4: must be the same places",
    ),
    "spacing of zero": ({"spacing": 0.0}, {}, "spacing = 0: must be one number, positive"),
    "spacing of text": ({"spacing": "a"}, {}, "type .*: must be real|does not state the spacing"),
    "two spacings": ({"spacing": np.array([0.3, 0.4])}, {}, "spacing = 0.3 x 0.4: must be one"),
    "coordinates in any order": ({"Z": WALL[:, ORDER], "x": X[ORDER], "y": Y}, {}, (0.3, 0.4)),
}  # fmt: skip


@pytest.mark.parametrize("suffix", [".npz", ".mat", ".nc"])
@pytest.mark.parametrize("case", FILES)
def test_what_places_heights_is_used_whole_or_refused(case, suffix, tmp_path):
    arrays, given, expected = FILES[case]
    path = tmp_path / f"a{suffix}"
    dimensions = ("row", "column") if case != "places of another array" else ("y", "x")
    if suffix == ".nc" and case in ("places of another array", "two spacings"):
        pytest.skip("a dimension has one length")
    write(path, {"Z": WALL} | arrays, dimensions)
    if isinstance(expected, tuple):
        scan = read_scan(path, units="mm", **given)
        assert scan.spacing == pytest.approx([1e-3 * step for step in expected])
        np.testing.assert_allclose(scan.heights, 1e-3 * WALL)
    else:
        with pytest.raises(jc.InputError, match=expected):
            read_scan(path, units="mm", **given)


@pytest.mark.parametrize("packed", [False, True])
@pytest.mark.parametrize("bounds", [{"valid_range": (-1, 1)}, {"valid_max": 1, "valid_min": -1}])
def test_heights_that_are_not_valid_by_the_cf_conventions_are_missing(bounds, packed, tmp_path):
    heights = np.clip(WALL, -0.9, 0.9)
    heights[2, 3], heights[4, 5] = 9.0, -7.0
    with netCDF4.Dataset(tmp_path / "a.nc", "w") as file:
        for name, n in zip("yx", heights.shape, strict=True):
            file.createDimension(name, n)
        z = file.createVariable("z_mm", "i2" if packed else "f8", ("y", "x"))
        for key, value in bounds.items():
            value = 1000 * np.array(value) if packed else np.array(value)
            z.setncattr(key, value.astype(z.dtype))
        if packed:
            z.scale_factor = 1e-3
        z.set_auto_mask(False)
        z[:] = heights
    scan = read_scan(tmp_path / "a.nc", scan_spacing=3e-4)
    np.testing.assert_array_equal(np.isnan(scan.heights), np.abs(heights) > 1.0)
    np.testing.assert_allclose(np.nan_to_num(scan.heights[0]), 1e-3 * heights[0], atol=6e-7)


def test_of_a_matlab_file_only_what_is_needed_is_loaded(tmp_path, monkeypatch):
    large = np.zeros((60, 1000))
    content = {"Z_mm": WALL, "h_mm": 0.3, "other": large}
    scipy.io.savemat(tmp_path / "a.mat", content, do_compression=True)
    monkeypatch.setattr(contents, "LARGEST_ARRAY", 100_000)
    with patch("scipy.io.loadmat", wraps=scipy.io.loadmat) as load:
        scan = read_scan(tmp_path / "a.mat", variable="Z_mm")
        with pytest.raises(jc.InputError, match="60 x 1000 values of 8 bytes: must be at"):
            read_scan(tmp_path / "a.mat", variable="other")
    np.testing.assert_allclose(scan.heights, 1e-3 * WALL)
    loaded = [name for call in load.call_args_list for name in call.kwargs["variable_names"]]
    assert sorted(loaded) == ["Z_mm", "h_mm"]


SPACED = {"Z": WALL, "dy": STEPS[0], "dx": STEPS[1]}
BESIDE = {
    "units": ({"units": "mm"}, {}, None),
    "other units": ({"units": "um"}, {"units": "mm"}, "units = 'mm': the heights of the file"),
    "units of heights": ({"z_units": "um"}, {"units": "mm"}, "heights of the file are in 'um'"),
    "another step": ({"units": "mm", "cell_size": 0.3}, {}, "states different spacings"),
    "another size": ({"units": "mm", "width_mm": 5.0}, {}, "states different spacings"),
    "a factor": ({"units": "mm", "scale": 1e3}, {}, "heights must be stored without a factor"),
    "another count": ({"units": "mm", "rows": 8}, {}, "states 8 rows; there are 9"),
}


@pytest.mark.parametrize("suffix", [".npz", ".mat", ".nc"])
@pytest.mark.parametrize("case", BESIDE)
def test_a_text_or_a_number_beside_heights_is_believed_or_refused(case, suffix, tmp_path):
    beside, given, printed = BESIDE[case]
    path = tmp_path / f"a{suffix}"
    if suffix == ".nc":
        dimensions = {"y": STEPS[0] * np.arange(9), "x": STEPS[1] * np.arange(12)}
        xr.Dataset({"Z": (("y", "x"), WALL)}, dimensions, beside).to_netcdf(path, engine="netcdf4")
    else:
        write(path, SPACED | beside)
    if printed is not None:
        with pytest.raises(jc.InputError, match=printed):
            read_scan(path, **given)
        return
    np.testing.assert_allclose(read_scan(path, **given).heights, 1e-3 * WALL)


@pytest.mark.parametrize(
    ("name", "attributes", "printed"),
    [
        ("z", {"unit": "mm"}, None),
        ("z", {"Units": "mm"}, None),
        ("z", {"long_name": "height [mm]"}, None),
        ("z_um", {"unit": "mm"}, "z_um: states the units 'mm' and 'um'"),
        ("z", {"units": "mm", "unit": "um"}, "z: states the units 'mm' and 'um'"),
        ("z", {"unit": "ft"}, "units = 'ft': must be one of"),
        ("z", {"unit": "counts"}, "units = 'counts': must be one of"),
    ],
)
def test_attributes_of_netcdf_state_units(name, attributes, printed, tmp_path):
    places = {axis: (axis, 0.3 * np.arange(n), {"unit": "mm"}) for axis, n in (("y", 9), ("x", 12))}
    dataset = xr.Dataset({name: (("y", "x"), WALL, attributes)}, places)
    dataset.to_netcdf(tmp_path / "a.nc", engine="netcdf4")
    if printed is None:
        np.testing.assert_allclose(read_scan(tmp_path / "a.nc").heights, 1e-3 * WALL)
    else:
        with pytest.raises(jc.InputError, match=printed):
            read_scan(tmp_path / "a.nc")


@pytest.mark.parametrize("suffix", [".npz", ".mat"])
def test_a_number_that_may_be_the_spacing_is_named(suffix, tmp_path):
    write(tmp_path / f"a{suffix}", SPACED | {"resolution": 0.3})
    remarks = " ".join(read_scan(tmp_path / f"a{suffix}", units="mm").remarks)
    assert "'resolution: 0.3', which was not used" in remarks

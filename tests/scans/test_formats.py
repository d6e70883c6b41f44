"""Each format gives back the wall that was written to it, or says what is wrong with the file."""

import pickle

import numpy as np
import pytest
import xarray as xr

import jointclosure as jc
from jointclosure.scans import read_scan
from jointclosure.surface.measured import Cloud, Scan, wall_on_grid
from jointclosure.surface.roughness import detrended
from tests.conftest import SPACING

STEP_MM = 1e3 * SPACING


@pytest.fixture(scope="module")
def wall():
    """A wall of 20 x 26 cells [mm] on a plane: rows cannot be taken for columns."""
    heights = 1e3 * jc.wall_pair(9.0, (20, 26), SPACING, seed=5)[0]
    return heights + 0.02 * np.arange(26) - 0.01 * np.arange(20)[:, None] + 3.0


def points_of(wall):
    y, x = np.indices(wall.shape) * STEP_MM
    return np.stack([x.ravel(), y.ravel(), wall.ravel()], axis=1)


def write_npy(path, wall):
    np.save(path, wall)
    return {"units": "mm", "spacing": SPACING}


def write_npz(path, wall):
    np.savez(path, Z_mm=wall, spacing_mm=STEP_MM, when=np.arange(3))
    return {}


def write_netcdf(path, wall):
    ny, nx = wall.shape
    coordinates = {
        "y": ("y", 1e-3 * STEP_MM * np.arange(ny), {"units": "m"}),
        "x": ("x", 1e-3 * STEP_MM * np.arange(nx), {"units": "m"}),
    }
    height = (("y", "x"), 1e3 * wall, {"units": "micrometre"})
    xr.Dataset({"height": height}, coordinates).to_netcdf(path, engine="netcdf4")
    return {}


def write_csv(path, wall):
    rows = [f"{x!r},{y!r},{z!r}" for x, y, z in points_of(wall).tolist()]
    path.write_text("# a scan\nx_mm,y_mm,z (mm)\n" + "\n".join(rows) + "\n")
    return {}


def write_xyz(path, wall):
    shuffled = np.random.default_rng(1).permutation(points_of(wall))
    np.savetxt(path, 1e3 * shuffled, fmt="%.9f")
    return {"units": "um"}


def write_tiff(path, wall):
    tifffile = pytest.importorskip("tifffile")
    tifffile.imwrite(path, wall.astype(np.float64))
    return {"units": "mm", "spacing": SPACING}


def write_geotiff(path, wall):
    tifffile = pytest.importorskip("tifffile")
    keys = (1, 1, 0, 2, 3076, 0, 1, 9001, 4099, 0, 1, 9001)
    tags = [
        (33550, "d", 3, (1e-3 * STEP_MM, 1e-3 * STEP_MM, 0.0), True),
        (33922, "d", 6, (0.0,) * 6, True),
        (34735, "H", len(keys), keys, True),
        (42113, "s", 0, "-9999", True),
    ]
    tifffile.imwrite(path, np.where(np.isnan(wall), -9999.0, 1e-3 * wall), extratags=tags)
    return {}


def write_stl(path, wall):
    trimesh = pytest.importorskip("trimesh")
    ny, nx = wall.shape
    corner = (np.arange(ny - 1)[:, None] * nx + np.arange(nx - 1)).ravel()
    faces = [np.stack([corner, corner + 1, corner + nx], axis=1)]
    faces.append(np.stack([corner + 1, corner + nx + 1, corner + nx], axis=1))
    path.write_bytes(
        trimesh.Trimesh(points_of(wall), np.concatenate(faces), process=False).export(
            file_type="stl"
        )
    )
    return {"units": "mm"}


def write_asc(path, wall):
    """A plain text matrix with a header, as Gwyddion writes it, by SurfaceTopography."""
    pytest.importorskip("SurfaceTopography")
    ny, nx = wall.shape
    header = f"# Channel: Height\n# Width: {nx * STEP_MM} mm\n# Height: {ny * STEP_MM} mm\n"
    with path.open("w") as file:
        file.write(header + "# Value units: mm\n")
        np.savetxt(file, wall, fmt="%.12g")
    return {}


FORMATS = {
    "a.npy": write_npy,
    "a.npz": write_npz,
    "a.nc": write_netcdf,
    "a.csv": write_csv,
    "a.xyz": write_xyz,
    "a.tif": write_tiff,
    "geo.tiff": write_geotiff,
    "a.stl": write_stl,
    "a.asc": write_asc,
}


@pytest.mark.parametrize("name", FORMATS)
def test_a_wall_comes_back_from_each_format_in_metres_without_its_plane(name, wall, tmp_path):
    given = FORMATS[name](tmp_path / name, wall)
    scan = read_scan(tmp_path / name, **given)
    found = wall_on_grid(scan, SPACING)
    assert found.shape == wall.shape
    # single precision in STL, of heights of 3 mm
    np.testing.assert_allclose(found, 1e-3 * detrended(wall), atol=1e-8 if ".stl" in name else 1e-9)
    if ".stl" not in name:
        assert isinstance(scan, Scan)
        np.testing.assert_allclose(scan.spacing, SPACING, rtol=1e-6)


@pytest.mark.parametrize("name", ["a.npy", "a.npz", "a.nc", "a.csv", "a.xyz", "geo.tiff"])
def test_cells_that_were_not_seen_stay_missing(name, wall, tmp_path):
    holed = wall.copy()
    holed[3:6, 10:14] = np.nan
    found = read_scan(tmp_path / name, **FORMATS[name](tmp_path / name, holed)).heights
    np.testing.assert_array_equal(np.isnan(found), np.isnan(holed))


@pytest.mark.parametrize("name", ["a.npy", "a.npz"])
def test_a_pickle_is_refused_and_not_run(name, tmp_path):
    class Trap:
        def __reduce__(self):
            return (exec, (f"open({str(tmp_path / 'sprung')!r}, 'w')",))

    path = tmp_path / name
    trapped = np.array([[Trap(), 0.0], [0.0, 1.0]], dtype=object)
    np.save(path, trapped) if name == "a.npy" else np.savez(path, Z_mm=trapped)
    with pytest.raises(jc.InputError, match=rf"{name}: .*allow_pickle"):
        read_scan(path, units="mm", spacing=SPACING)
    path.write_bytes(pickle.dumps(Trap()))
    with pytest.raises(jc.InputError, match=rf"{name}: cannot be read as an array"):
        read_scan(path, units="mm", spacing=SPACING)
    assert not (tmp_path / "sprung").exists()


@pytest.mark.parametrize("name", [*FORMATS, "scan.x3p", "scan.unknown"])
@pytest.mark.parametrize("damage", ["truncated", "empty", "noise"])
def test_a_damaged_file_is_one_clear_error(name, damage, wall, tmp_path):
    path = tmp_path / name
    given = FORMATS.get(name, write_npy)(path, wall) if name in FORMATS else {"units": "mm"}
    whole = path.read_bytes() if path.exists() else b"\x00" * 1000
    noise = np.random.default_rng(3).integers(0, 256, 500, dtype=np.uint8).tobytes()
    cut = whole[: len(whole) // 3] if name not in ("a.csv", "a.xyz", "a.asc") else whole[:9]
    path.write_bytes({"truncated": cut, "empty": b"", "noise": noise}[damage])
    with pytest.raises(jc.InputError, match=name):
        wall_on_grid(read_scan(path, **given), SPACING)


REFUSED = [
    ("a.npy", {"spacing": SPACING}, "does not say the units of its heights"),
    ("a.npy", {"units": "mm"}, "does not say the spacing"),
    (
        "a.npy",
        {"units": "inch", "spacing": SPACING},
        "units = 'inch': must be one of m, mm, um, nm",
    ),
    ("a.npy", {"units": "mm", "spacing": SPACING, "variable": "z"}, "variable = 'z'"),
    ("a.npz", {"units": "um"}, "units = 'um': the file says that its heights are in 'mm'"),
    ("a.npz", {"spacing": 2 * SPACING}, "spacing = 0.5 mm: the file says 0.25 mm"),
    ("a.npz", {"variable": "Q"}, "variable = 'Q': must be one of Z_mm, spacing_mm, when"),
    ("a.nc", {"units": "mm"}, "units = 'mm': the file says that its heights are in 'micrometre'"),
    ("a.nc", {"units": "um"}, "units = 'um': the file says that its distances are in 'm'"),
    ("a.nc", {"variable": "depth"}, "variable = 'depth': must be one of height"),
    ("a.csv", {"units": "m"}, "units = 'm': the file says that its heights are in 'mm'"),
    ("a.xyz", {}, "does not say the units"),
    ("geo.tiff", {"units": "mm"}, "the file says that its heights are in 'm'"),
    ("a.stl", {}, "does not say the units"),
    ("a.stl", {"units": "mm", "spacing": SPACING}, "these are points"),
    ("a.asc", {"units": "um"}, "units = 'um': the file says that its heights are in 'mm'"),
]


@pytest.mark.parametrize(("name", "given", "said"), REFUSED)
def test_units_and_spacing_are_stated_once_and_not_contradicted(name, given, said, wall, tmp_path):
    FORMATS[name](tmp_path / name, wall)
    with pytest.raises(jc.InputError, match=name) as error:
        read_scan(tmp_path / name, **given)
    assert said in str(error.value)


def test_units_that_repeat_those_of_the_file_are_no_contradiction(wall, tmp_path):
    write_csv(tmp_path / "a.csv", wall)
    plain, stated = (read_scan(tmp_path / "a.csv", **given) for given in ({}, {"units": "mm"}))
    np.testing.assert_array_equal(plain.heights, stated.heights)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("1 2\n3 4\n", "2 columns without names"),
        ("1,2,3,4\n", "4 columns without names"),
        ("a,b,c\n1,2,3\n", "must name x, y and z"),
        ("x,y,z\n1,2,three\n", "three"),
        ("x,y,z\n1,,3\n", "1 points lack x or y, the first is number 1"),
        ("x_mm,y_m,z\n1,2,3\n", "x is in mm and y in m"),
        ("# nothing\n", "has no points"),
        ("1 2 3\n2 3 4\n3 4 5\n4 5 6\n", "on one line"),
    ],
)
def test_text_that_is_no_points_is_refused(text, said, tmp_path):
    (tmp_path / "a.csv").write_text(text)
    with pytest.raises(jc.InputError) as error:
        wall_on_grid(read_scan(tmp_path / "a.csv", units="mm"), SPACING)
    assert said in str(error.value)


def test_scattered_points_are_a_cloud(tmp_path):
    points = np.random.default_rng(2).random((50, 3))
    np.savetxt(tmp_path / "a.xyz", points)
    scan = read_scan(tmp_path / "a.xyz", units="m")
    assert isinstance(scan, Cloud)
    np.testing.assert_allclose(scan.points, points)


def test_plain_formats_need_no_extra(wall, tmp_path, monkeypatch):
    for name in ("tifffile", "trimesh", "SurfaceTopography", "SurfaceTopography.IO"):
        monkeypatch.setitem(__import__("sys").modules, name, None)
    for name in ("a.npy", "a.npz", "a.nc", "a.csv", "a.xyz"):
        read_scan(tmp_path / name, **FORMATS[name](tmp_path / name, wall))
    for name in ("a.tif", "a.stl", "a.x3p"):
        (tmp_path / name).write_bytes(b"something")
        with pytest.raises(jc.InputError, match=r"jointclosure\[walls\]"):
            read_scan(tmp_path / name, units="mm", spacing=SPACING)

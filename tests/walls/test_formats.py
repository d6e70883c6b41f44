"""Each format gives back the wall that was written to it, or says what is wrong with the file."""

import io
import pickle
import struct
import zipfile

import numpy as np
import pytest
import scipy.io
import xarray as xr

import jointclosure as jc
from jointclosure.walls.measured import Cloud, Scan, point_distance, wall_on_grid
from jointclosure.walls.roughness import detrended
from jointclosure.walls.scans import read_scan
from tests.joints import SPACING, TWO_WALLS

STEP_MM = 1e3 * SPACING


@pytest.fixture(scope="module")
def wall():
    """A wall of 20 x 26 cells [mm] on a plane: rows cannot be taken for columns."""
    heights = 1e3 * jc.wall_pair(9.0, (20, 26), SPACING, seed=5, roll_off=None)[0]
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
    tifffile.imwrite(path, np.where(np.isnan(wall), -9999.0, 1e-3 * wall)[::-1], extratags=tags)
    return {}


def triangles(shape):
    """Corners of the triangles (n, 3) between the points of a grid."""
    ny, nx = shape
    corner = (np.arange(ny - 1)[:, None] * nx + np.arange(nx - 1)).ravel()
    first, second = [corner, corner + 1, corner + nx], [corner + 1, corner + nx + 1, corner + nx]
    return np.concatenate([np.stack(first, axis=1), np.stack(second, axis=1)])


def write_stl(path, wall):
    trimesh = pytest.importorskip("trimesh")
    mesh = trimesh.Trimesh(points_of(wall), triangles(wall.shape), process=False)
    path.write_bytes(mesh.export(file_type="stl"))
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


@pytest.mark.parametrize("name", ["a.npy", "a.nc", "a.xyz", "geo.tiff"])
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
    trapped = np.array([[Trap(), 0.0, 0.0], [0.0, 1.0, 0.0], [2.0, 3.0, 0.0]], dtype=object)
    np.save(path, trapped) if name == "a.npy" else np.savez(path, Z_mm=trapped)
    with pytest.raises(jc.InputError, match=rf"{name}: .*(allow_pickle|type object)"):
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
    ("a.npy", {"spacing": SPACING}, "does not state the units of its heights"),
    ("a.npy", {"units": "mm"}, "does not state the spacing"),
    (
        "a.npy",
        {"units": "inch", "spacing": SPACING},
        "units = 'inch': must be one of m, mm, um, nm",
    ),
    ("a.npy", {"units": "mm", "spacing": SPACING, "variable": "z"}, "variable = 'z'"),
    ("a.npz", {"units": "um"}, "units = 'um': the heights of the file are in 'mm'"),
    ("a.npz", {"spacing": 2 * SPACING}, "spacing = 0.5 mm: the file states 0.25 mm"),
    ("a.npz", {"variable": "Q"}, "variable = 'Q': must be one of Z_mm, spacing_mm, when"),
    ("a.nc", {"units": "mm"}, "units = 'mm': the heights of the file are in 'micrometre'"),
    ("a.nc", {"units": "um"}, "units = 'um': the distances of the file are in 'm'"),
    ("a.nc", {"variable": "depth"}, "variable = 'depth': must be one of height"),
    ("a.csv", {"units": "m"}, "units = 'm': the heights of the file are in 'mm'"),
    ("a.xyz", {}, "does not state the units"),
    ("geo.tiff", {"units": "mm"}, "the heights of the file are in 'm'"),
    ("a.stl", {}, "does not state the units"),
    ("a.stl", {"units": "mm", "spacing": 2 * SPACING}, "spacing = 0.5 mm: the file states 0.25 mm"),
    ("a.asc", {"units": "um"}, "units = 'um': the heights of the file are in 'mm'"),
]


@pytest.mark.parametrize(("name", "given", "printed"), REFUSED)
def test_units_and_spacing_are_stated_once_and_not_contradicted(
    name, given, printed, wall, tmp_path
):
    FORMATS[name](tmp_path / name, wall)
    with pytest.raises(jc.InputError, match=name) as error:
        read_scan(tmp_path / name, **given)
    assert printed in str(error.value)


@pytest.mark.parametrize(
    ("text", "printed"),
    [
        ("1 2\n3 4\n", "2 columns that are not named"),
        ("a,b,c\n1,2,3\n", "must be named x, y and z"),
        ("x,y,z\n1,,3\n", "1 points lack x or y, the first is number 1"),
        ("1 2 3\n2 3 4\n3 4 5\n4 5 6\n", "on one line"),
    ],
)
def test_text_that_is_no_points_is_refused(text, printed, tmp_path):
    (tmp_path / "a.csv").write_text(text)
    with pytest.raises(jc.InputError) as error:
        wall_on_grid(read_scan(tmp_path / "a.csv", units="mm"), SPACING)
    assert printed in str(error.value)


def test_text_as_instruments_and_people_write_it_is_read(wall, tmp_path):
    points = points_of(wall)
    commas = [f"{x:.9f},{y:.9f},{z:.9f}" for x, y, z in points]
    blanks = [f"{x:.9f} {y:.9f} {z:.9f}" for x, y, z in points]
    written = {
        "doubled header, trailing commas, DOS": "x,y,z\r\nx,y,z\r\n"
        + "".join(f"{line},\r\n" for line in commas)
        + "\r\n",
        "header again in the middle": "\n".join(["x,y,z", *commas[:9], "x,y,z", *commas[9:]]),
        "semicolons and decimal commas": "\n".join(
            ["x;y;z", *(line.replace(" ", ";").replace(".", ",") for line in blanks)]
        ),
        "tabs": "\n".join(line.replace(" ", "\t") for line in blanks),
        "blanks and decimal commas": "\n".join(line.replace(".", ",") for line in blanks),
        "aligned": "\n".join("   " + line.replace(" ", "    ") for line in blanks),
        "commas and blanks": "\n".join(line.replace(",", " , ") for line in commas),
        "title, count of points, comments": "\n".join(
            ["Scan 7", str(len(points)), "% by hand", *blanks[:4], "# half", *blanks[4:]]
        ),
        "further columns": "\n".join(
            ["id,x,y,z,quality", *(f"{i},{line},good" for i, line in enumerate(commas))]
        ).replace("good", "1"),
        "byte order mark": "\ufeffX,Y,Z\n" + "\n".join(commas),
    }
    plain = tmp_path / "plain.txt"
    plain.write_text("\n".join(commas))
    expected = read_scan(plain, units="mm")
    for number, (what, text) in enumerate(written.items()):
        path = tmp_path / f"{number}.txt"
        path.write_bytes(text.encode())
        found = read_scan(path, units="mm")
        assert isinstance(found, Scan), what
        np.testing.assert_allclose(found.heights, expected.heights, err_msg=what)
        assert found.spacing == pytest.approx((SPACING, SPACING)), what
    path.write_bytes(text.removeprefix("\ufeff").encode("utf-16"))
    np.testing.assert_allclose(read_scan(path, units="mm").heights, expected.heights)


@pytest.mark.parametrize(
    "head",
    [
        "x_mm,y_mm,z_um",
        "# x [mm] y [mm] z [um]",
        "X (mm);Y (mm);Z (µm)",
        "X Position [MM];Y Position [MM];Height [UM]",
        "x/mm y/mm z/um",
        "X, mm;Y, mm;Z, um",
    ],
)
def test_a_head_says_the_units_also_as_a_comment(head, wall, tmp_path):
    lines = [f"{x:.9f} {y:.9f} {1e3 * z:.9f}" for x, y, z in points_of(wall)]
    (tmp_path / "a.txt").write_bytes("\n".join([head, *lines]).encode("latin-1"))
    np.testing.assert_allclose(read_scan(tmp_path / "a.txt").heights, 1e-3 * wall, atol=1e-12)


LETTER = "Dear all,\nthe scan is lost.\n"
TEXT_PLY = (
    b"ply\nformat ascii 1.0\nelement vertex 6\nproperty float x\nproperty float y\n"
    b"property float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n"
    b"0 0 2\n1 0 2\n2 0 2\n2 1 2\n1 1 2\n0 1 2\n3 0 1 2\n"
)
UNLIKE = {
    "a.foo": (LETTER.encode(), "text"),
    "a.stl": (b"\x89PNG\r\n\x1a\n" + bytes(80), "PNG"),
    "a.npy": (b"PK\x03\x04" + bytes(80), "archive"),
    "b.foo": (bytes(range(256)), "no form"),
    "empty.xyz": (b"", "empty"),
    "a.obj": (b"v 0 0 0\nv 1 0 x\n", "line 2"),
    "b.obj": (b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n", "vertex 9"),
    "c.obj": (LETTER.encode(), "no vertices"),
    "d.obj": (b"# Vertices: 9\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\n", "declares 9 vertices, and"),
    "e.obj": (b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf -1 -2 -9\n", "line 4"),
    "f.obj": (b"v 0 0 0\nv 1 1 0 0\n", "line 2, 'v 1 1 0 0'"),
    "b.ply": (TEXT_PLY.rpartition(b"0 1 2\n3")[0], "declares 6 vertices, and contains 5"),
    "c.ply": (TEXT_PLY.replace(b"1 1 2", b"1 2"), "cannot be read as PLY"),
    "e.ply": (
        TEXT_PLY.replace(b"3 0 1 2", b"3 0 1 9"),
        "a face has vertex 10, but there are 6 vertices",
    ),
    "a.asc": (b"# scan\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", "OBJ mesh"),
    "a.grd": (b"DSRB" + bytes(4), "lacks the section DATA, GRID"),
}


@pytest.mark.parametrize("name", UNLIKE)
def test_a_file_of_no_form_is_refused_in_one_line_with_the_nearest_form(name, tmp_path):
    content, nearest = UNLIKE[name]
    (tmp_path / name).write_bytes(content)
    with pytest.raises(jc.InputError, match=nearest) as error:
        read_scan(tmp_path / name, units="mm")
    assert len(str(error.value).splitlines()) == 1


CORNERS = {
    "0": " ",
    "99.5": ",",
    "nan": "\t",
    "y/x": " ",
    "y\\x": ";",
    "": "\t",
    "no corner": " ",
    "none": ",",
}


@pytest.mark.parametrize("corner", CORNERS)
@pytest.mark.parametrize("falling", [False, True])
def test_a_matrix_framed_by_its_places_is_that_grid(corner, falling, wall, tmp_path):
    mark = CORNERS[corner]
    x, y = 3.0 + STEP_MM * np.arange(26), 7.0 + STEP_MM * np.arange(20)
    step = -1 if falling else 1
    head = [*x.astype(str)] if corner == "no corner" else [corner, *x.astype(str)]
    rows = [[str(at), *(f"{z:.9f}" for z in row)] for at, row in zip(y, wall, strict=True)]
    lines = [mark.join(cells) for cells in [head, *rows[::step]]]
    (tmp_path / "a.txt").write_text("\n".join(lines))
    scan = read_scan(tmp_path / "a.txt", units="mm")
    np.testing.assert_allclose(scan.heights, 1e-3 * wall, atol=1e-12)
    assert scan.spacing == pytest.approx((SPACING, SPACING))
    assert scan.origin == pytest.approx((7e-3, 3e-3))
    assert "were read as x and y" in " ".join(scan.remarks)


@pytest.mark.parametrize(("line", "cut"), [("row", np.s_[:, 1:]), ("column", np.s_[1:])])
def test_a_matrix_with_places_on_one_side_only_is_refused(line, cut, wall, tmp_path):
    framed = np.pad(wall, ((1, 0), (1, 0)))
    framed[0, 1:], framed[1:, 0] = STEP_MM * np.arange(26), STEP_MM * np.arange(20)
    np.savetxt(tmp_path / "a.txt", framed[cut], "%.6f")
    with pytest.raises(jc.InputError, match=f"its first {line} is evenly spaced"):
        read_scan(tmp_path / "a.txt", units="mm", spacing=SPACING)


def test_heights_of_a_plane_are_not_taken_for_places(tmp_path):
    plane = 0.02 * np.arange(26) - 0.01 * np.arange(20)[:, None]
    np.savetxt(tmp_path / "a.txt", plane, "%.6f")
    scan = read_scan(tmp_path / "a.txt", units="mm", spacing=SPACING)
    np.testing.assert_allclose(scan.heights, 1e-3 * plane, atol=1e-12)


def matlab_contents(wall):
    """A wall in the forms in which MATLAB programs keep it, and the array that is read."""
    x, y = STEP_MM * np.arange(26), STEP_MM * np.arange(20)
    across, along = np.meshgrid(x, y)
    text = {"operator": "A. N. Other"}
    both = np.array([(x, y, wall + 1.0), (x, y, wall)], [("x", "O"), ("y", "O"), ("Z", "O")])
    return {
        "struct": ({"S": {"X_mm": across, "Y_mm": along, "Z_mm": wall} | text}, "S.Z_mm"),
        "nested": ({"scan": {"S": {"x": x, "y": y, "Z": wall}}, "n": 3}, "scan.S.Z"),
        "vectors": ({"x": x, "y": y, "Z": wall}, "Z"),
        "rows along x": ({"x": x, "y": y, "Z": wall.T}, "Z"),
        "spacing": ({"S": {"spacing": STEP_MM, "Z": wall}}, "S.Z"),
        "two": ({"S": both}, "S(2).Z"),
    }


@pytest.mark.parametrize("kept", ["struct", "nested", "vectors", "rows along x", "spacing", "two"])
def test_structs_and_vectors_of_places_of_a_matlab_file_are_read(kept, wall, tmp_path):
    content, name = matlab_contents(wall)[kept]
    scipy.io.savemat(tmp_path / "a.mat", content)
    for variable in (name, None):
        if kept == "two" and variable is None:
            with pytest.raises(jc.InputError, match=r"S\(1\).Z, S\(2\).Z; variable \(--variable"):
                read_scan(tmp_path / "a.mat", units="mm")
            continue
        scan = read_scan(tmp_path / "a.mat", units="mm", variable=variable)
        np.testing.assert_allclose(scan.heights, 1e-3 * wall, atol=1e-12)
        assert scan.spacing == pytest.approx((SPACING, SPACING))


def test_a_matlab_file_without_an_array_is_refused_in_a_sentence_of_its_own(tmp_path):
    scipy.io.savemat(tmp_path / "a.mat", {"S": {"x": np.arange(5.0)}, "n": 3})
    with pytest.raises(jc.InputError, match=r"has no array over \(y, x\); it contains S.x, n$"):
        read_scan(tmp_path / "a.mat", units="mm")


def binary_stl(count=4):
    """A binary STL file of triangles side by side."""
    triangle = np.array([0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0], "<f4").tobytes() + bytes(2)
    return b"exported".ljust(80) + struct.pack("<I", count) + triangle * count


PLY = (
    b"ply\nformat binary_little_endian 1.0\nelement vertex 9\nproperty float x\n"
    b"property float y\nproperty float z\nend_header\n" + bytes(range(108))
)
HINTS = {
    "a.ply": (binary_stl(), "its content is that of an STL mesh"),
    "cut.stl": (binary_stl()[:200], "4 triangles, 284 bytes, and contains 200: is the file inc"),
    "short.stl": (
        binary_stl()[:82],
        "contains 82 bytes, less than the head of 84: is the file incomplete",
    ),
    "a.txt": (PLY, "is not text: it contains binary data; its content is that of a PLY mesh"),
    "cut.grd": (b"DSBB" + struct.pack("<2h6d", 9, 9, *range(6)) + bytes(40), "and contains 10: is"),
    "a.npy": (bytes(range(256)), "cannot be read as an array of numbers"),
    "b.txt": (bytes(range(256)), "is not text: it contains binary data"),
}


@pytest.mark.parametrize("name", HINTS)
def test_a_hint_is_given_only_for_a_known_form_and_no_bytes_are_printed(name, tmp_path):
    content, printed = HINTS[name]
    (tmp_path / name).write_bytes(content)
    with pytest.raises(jc.InputError) as error:
        read_scan(tmp_path / name, units="mm")
    message = str(error.value)
    assert printed in message
    assert ("its content" in message) == ("its content" in printed)
    assert message.isprintable()
    for wrong in ("\\x", "no form", "too few"):
        assert wrong not in message


def test_a_solid_in_a_file_of_the_right_name_is_refused_without_a_hint(tmp_path):
    trimesh = pytest.importorskip("trimesh")
    (tmp_path / "a.stl").write_bytes(trimesh.creation.box().export(file_type="stl"))
    with pytest.raises(jc.InputError, match=r"must be cut to one wall$"):
        read_scan(tmp_path / "a.stl", units="mm")


@pytest.mark.parametrize("name", ["a.ply", "a.obj"])
def test_vertices_without_a_face_are_used_and_counted(name, wall, tmp_path):
    trimesh = pytest.importorskip("trimesh")
    mesh = trimesh.Trimesh(points_of(wall), [[0, 1, 26], [2, 3, 28]], process=False)
    content = mesh.export(file_type=name[2:])
    (tmp_path / name).write_bytes(content.encode() if isinstance(content, str) else content)
    scan = read_scan(tmp_path / name, units="mm")
    np.testing.assert_allclose(scan.heights, 1e-3 * wall, atol=1e-8)
    assert "514 of 520 vertices belong to no face; they were used" in " ".join(scan.remarks)


@pytest.mark.parametrize("head", ["", "depth,east,north,height\n"])
@pytest.mark.parametrize("columns", ["2,3,4", "east,north,height"])
def test_columns_are_chosen_by_number_or_name(head, columns, wall, tmp_path):
    lines = [f"7,{x:.9f},{y:.9f},{z:.9f}" for x, y, z in points_of(wall)]
    (tmp_path / "a.csv").write_text(head + "\n".join(lines))
    if columns[0] == "e" and not head:
        with pytest.raises(jc.InputError, match="there are numbers from 1 to 4"):
            read_scan(tmp_path / "a.csv", units="mm", variable=columns)
        return
    found = read_scan(tmp_path / "a.csv", units="mm", variable=columns)
    np.testing.assert_allclose(found.heights, 1e-3 * wall, atol=1e-12)


@pytest.mark.parametrize("name", ["a.npy", "a.csv", "a.tif"])
@pytest.mark.parametrize("sentinel", [-9999.0, 9999.0, 1e30])
def test_an_undeclared_sentinel_is_no_height(name, sentinel, wall, tmp_path):
    coded, holed = wall.copy(), wall.copy()
    coded[3:6, 10:14] = sentinel
    holed[3:6, 10:14] = np.nan
    scan = read_scan(tmp_path / name, **FORMATS[name](tmp_path / name, coded))
    np.testing.assert_allclose(scan.heights, 1e-3 * holed, atol=1e-12)
    assert f"{sentinel:g} were treated as missing" in " ".join(scan.remarks)
    assert "12 " in " ".join(scan.remarks)


@pytest.mark.parametrize("name", ["a.xyz", "a.stl"])
def test_a_stray_point_is_cut_and_named(name, tmp_path):
    points = np.random.default_rng(2).random((2000, 3)) * [10.0, 10.0, 0.1]
    far = np.vstack([points, [1e6, -2e6, 0.05], [4.0, 5.0, 700.0]])
    if name == "a.xyz":
        np.savetxt(tmp_path / name, far)
    else:
        trimesh = pytest.importorskip("trimesh")
        faces = np.arange(len(far)).reshape(-1, 2)
        faces = np.column_stack([faces, np.roll(faces[:, 0], 1)])
        mesh = trimesh.Trimesh(far, faces, process=False)
        (tmp_path / name).write_bytes(mesh.export(file_type="stl"))
    scan = read_scan(tmp_path / name, units="mm")
    assert len(scan.points) == 2000
    assert np.abs(scan.points).max() <= 10e-3
    printed, scattered = scan.remarks
    assert "Warning: the points lie on no regular grid" in scattered
    assert printed.startswith("2 stray points were cut")
    assert "(1e+06, -2e+06, 0.05), (4, 5, 700)" in printed or name == "a.stl"


def test_points_that_no_scan_has_so_far_apart_are_refused_and_no_terabyte_asked_for():
    points = np.random.default_rng(2).random((400, 3)) * [1.0, 1.0, 1e-5]
    points[:200, 1] += 1e6
    points[:, 0] += points[:, 1]
    with pytest.raises(jc.InputError, match="at most 100 cells for each point"):
        wall_on_grid(Cloud(points), point_distance(Cloud(points)))


@pytest.mark.parametrize("spacing", ["a", np.array("0.25"), 1j])
def test_a_spacing_that_is_no_number_is_named(spacing, wall, tmp_path):
    np.savez(tmp_path / "a.npz", Z_mm=wall, spacing_mm=spacing)
    with pytest.raises(jc.InputError, match=r"a\.npz: spacing_mm: values of type .*: must be real"):
        read_scan(tmp_path / "a.npz")


@pytest.mark.parametrize(("word", "fails"), [("none", False), ("nan", False), ("lots", True)])
def test_a_no_data_value_that_is_no_number_is_none_or_named(word, fails, wall, tmp_path):
    tifffile = pytest.importorskip("tifffile")
    tifffile.imwrite(tmp_path / "a.tif", wall, extratags=[(42113, "s", 0, word, True)])
    if fails:
        with pytest.raises(jc.InputError, match=r"a\.tif: GDAL_NODATA = 'lots': must be a number"):
            read_scan(tmp_path / "a.tif", units="mm", spacing=SPACING)
    else:
        found = read_scan(tmp_path / "a.tif", units="mm", spacing=SPACING)
        np.testing.assert_allclose(found.heights, 1e-3 * wall)


def test_both_walls_of_a_published_fracture_are_read():
    if not TWO_WALLS.is_dir():
        pytest.skip("the two walls are not here")
    for name in ("side_a_bottom.txt", "side_b_top.txt"):
        scan = read_scan(TWO_WALLS / name, units="mm")
        lines = (TWO_WALLS / name).read_text().splitlines()
        assert len(scan.points) == sum(line.count(".") >= 2 for line in lines)
        np.testing.assert_allclose(np.ptp(scan.points[:, :2], axis=0), 65e-3, rtol=0.002)


def test_scattered_points_are_a_cloud(tmp_path):
    points = np.random.default_rng(2).random((50, 3))
    np.savetxt(tmp_path / "a.xyz", points)
    scan = read_scan(tmp_path / "a.xyz", units="m")
    assert isinstance(scan, Cloud)
    np.testing.assert_allclose(scan.points, points)


def test_geotiffs_of_one_frame_stay_in_it(tmp_path):
    """Two scans of the same ground whose first pixels are apart have origins apart."""
    tifffile = pytest.importorskip("tifffile")
    ground = np.arange(80.0).reshape(8, 10) ** 1.5
    keys = (1, 1, 0, 2, 3076, 0, 1, 9001, 4099, 0, 1, 9001)
    scans = []
    for name, rows, columns in (("a.tif", 0, 0), ("b.tif", 2, 3)):
        tags = [
            (33550, "d", 3, (0.5, 0.25, 0.0), True),
            (33922, "d", 6, (0.0, 0.0, 0.0, 100.0 + 0.5 * columns, 700.0 - 0.25 * rows, 0.0), True),
            (34735, "H", len(keys), keys, True),
        ]
        tifffile.imwrite(tmp_path / name, ground[rows:, columns:], extratags=tags)
        scans.append(read_scan(tmp_path / name))
    assert np.subtract(scans[1].origin, scans[0].origin) == pytest.approx((0.0, 1.5))
    np.testing.assert_array_equal(scans[0].heights[:6, 3:], scans[1].heights)


def write_esri(path, wall, rows=None, **head):
    """An ESRI grid: rows from the largest y downwards."""
    ny, nx = wall.shape
    words = {"ncols": nx, "nrows": ny, "xllcorner": 3.0, "yllcorner": 5.0, "cellsize": STEP_MM}
    words |= {"NODATA_value": -9999} | head
    with path.open("w") as file:
        file.writelines(f"{key} {value}\n" for key, value in words.items() if value is not None)
        np.savetxt(file, np.where(np.isnan(wall), -9999, wall)[::-1][:rows], fmt="%.9f")


def test_an_esri_grid_has_its_spacing_its_place_and_its_missing_heights(wall, tmp_path):
    holed = wall.copy()
    holed[3:6, 10:14] = np.nan
    write_esri(tmp_path / "a.asc", holed)
    scan = read_scan(tmp_path / "a.asc", units="mm")
    np.testing.assert_allclose(scan.heights, 1e-3 * holed, atol=1e-12)
    assert scan.spacing == pytest.approx((SPACING, SPACING))
    assert scan.origin == pytest.approx((5e-3 + 0.5 * SPACING, 3e-3 + 0.5 * SPACING))


def test_a_row_of_an_esri_grid_that_lost_a_number_is_named(wall, tmp_path):
    write_esri(tmp_path / "a.asc", wall)
    rows = (tmp_path / "a.asc").read_text().splitlines()
    words = [word for row in rows[6:] for word in row.split()]
    divided = [" ".join(words[start : start + 10]) for start in range(0, len(words), 10)]
    (tmp_path / "b.asc").write_text("\n".join(rows[:6] + divided))
    scan = read_scan(tmp_path / "b.asc", units="mm")
    np.testing.assert_allclose(scan.heights, 1e-3 * wall, atol=1e-12)
    rows[10] = rows[10].partition(" ")[2]
    rows[17] += " 1.0"
    (tmp_path / "a.asc").write_text("\n".join(rows))
    with pytest.raises(jc.InputError, match=r"row 5 contains 25 heights, must be 26 \(2 such rows"):
        read_scan(tmp_path / "a.asc", units="mm")


@pytest.mark.parametrize(
    ("rows", "head", "printed"),
    [
        (12, {}, "declares 20 rows of 26 heights, 520, and contains 312"),
        (None, {"cellsize": None}, "header lacks cellsize"),
        (None, {"nrows": 10**9}, "at most 800 MB"),
        (None, {"cellsize": None, "dx": 0.25, "dy": 0.5}, "dx = 0.25, dy = 0.5: must be equal"),
        (None, {"cellsize": None, "dx": 0.25}, "header lacks cellsize"),
    ],
)
def test_an_esri_grid_that_is_not_what_it_declares_is_refused(rows, head, printed, wall, tmp_path):
    write_esri(tmp_path / "a.asc", wall, rows, **head)
    with pytest.raises(jc.InputError, match=rf"a\.asc: .*{printed}") as error:
        read_scan(tmp_path / "a.asc", units="mm")
    assert "rename" not in str(error.value)


def test_equal_dx_and_dy_of_an_esri_grid_are_its_cell_size(wall, tmp_path):
    write_esri(tmp_path / "a.asc", wall)
    write_esri(tmp_path / "b.asc", wall, cellsize=None, dx=STEP_MM, dy=STEP_MM)
    usual, of_gdal = (read_scan(tmp_path / name, units="mm") for name in ("a.asc", "b.asc"))
    np.testing.assert_array_equal(of_gdal.heights, usual.heights)
    assert (of_gdal.spacing, of_gdal.origin) == (usual.spacing, usual.origin)


def netcdf_wall(wall, dims, attributes=({}, {}), step=STEP_MM):
    """A wall (y, x) as a dataset whose dimensions have other names or another order."""
    places = {
        dim: (dim, step * np.arange(size), {"units": "mm"} | about)
        for dim, size, about in zip(dims, wall.shape, attributes, strict=True)
    }
    return xr.Dataset({"height": (dims, wall, {"units": "mm"})}, places)


@pytest.mark.parametrize(
    ("dims", "attributes"),
    [
        (("northing", "easting"), ({}, {})),
        (("a", "b"), ({"axis": "Y"}, {"axis": "X"})),
        (("a", "b"), ({"standard_name": "projection_y_coordinate"}, {})),
        (("first", "second"), ({}, {})),
    ],
)
def test_a_netcdf_grid_is_turned_by_the_names_of_its_dimensions(dims, attributes, wall, tmp_path):
    dataset = netcdf_wall(wall, dims, attributes)
    if dims[0] != "first":
        dataset = dataset.transpose(*dims[::-1])
    dataset.to_netcdf(tmp_path / "a.nc", engine="netcdf4")
    scan = read_scan(tmp_path / "a.nc")
    np.testing.assert_allclose(scan.heights, 1e-3 * wall)
    assert any("read as y, x" in remark for remark in scan.remarks) == (dims[0] == "first")


@pytest.mark.parametrize("name", ["a.npy", "a.csv", "a.asc"])
def test_a_patch_of_zeros_among_other_heights_is_missing(name, wall, tmp_path):
    level = wall - wall.mean()  # heights on both sides of 0
    coded, holed = level.copy(), level.copy()
    coded[3:6, 10:15], holed[3:6, 10:15] = 0.0, np.nan
    scan = read_scan(tmp_path / name, **FORMATS[name](tmp_path / name, coded))
    np.testing.assert_allclose(scan.heights, 1e-3 * holed, atol=1e-12)
    assert "Warning: 15 of 520 heights are exactly 0" in " ".join(scan.remarks)


def test_zeros_that_are_heights_stay(wall, tmp_path):
    rounded = np.round(wall - wall.mean(), 2)  # values come in dozens
    block = np.zeros((20, 26))
    block[4:8, 5:9] = 0.1 * np.arange(16).reshape(4, 4) + 0.1
    lowest = wall - wall.min()
    for heights in (rounded, block, lowest):
        np.save(tmp_path / "a.npy", heights)
        scan = read_scan(tmp_path / "a.npy", units="mm", spacing=SPACING)
        np.testing.assert_allclose(scan.heights, 1e-3 * heights)


@pytest.mark.parametrize("name", ["a.npy", "a.tif", "a.csv"])
def test_a_file_without_any_height_is_refused(name, wall, tmp_path):
    given = FORMATS[name](tmp_path / name, np.full(wall.shape, np.nan))
    with pytest.raises(jc.InputError, match=name):
        wall_on_grid(read_scan(tmp_path / name, **given), SPACING)


def test_an_archive_that_declares_more_than_a_scan_is_refused_unread(wall, tmp_path):
    """Zeros are packed a thousand times: of a bomb nothing but the head may be read."""
    path = tmp_path / "a.npz"
    np.savez(path, Z_mm=wall, spacing_mm=STEP_MM)
    head = io.BytesIO()
    declared = {"descr": "<f8", "fortran_order": False, "shape": (40_000, 25_000)}
    np.lib.format.write_array_header_1_0(head, declared)
    with zipfile.ZipFile(path, "a") as archive:
        archive.writestr("other.npy", head.getvalue())
    assert read_scan(path, variable="Z_mm").heights.shape == wall.shape
    for name in ("a.npz", "a.npy"):
        if name == "a.npy":
            (tmp_path / name).write_bytes(head.getvalue())
        given = {"variable": "other"} if name == "a.npz" else {}
        with pytest.raises(
            jc.InputError, match=r"declares 40000 x 25000 values of 8 bytes: must be at most 800 MB"
        ):
            read_scan(tmp_path / name, units="mm", spacing=SPACING, **given)

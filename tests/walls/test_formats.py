"""Each form gives back the wall that was written, or says what is wrong with the file."""

import io
import pickle
import re
import struct
import zipfile

import numpy as np
import pandas as pd
import pytest
import scipy.io
import xarray as xr
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import jointclosure as jc
from jointclosure.walls.gridding import Cloud, Scan, point_distance, wall_on_grid
from jointclosure.walls.scans import read_scan
from tests.joints import SPACING
from tests.walls import writers
from tests.walls.writers import FORMS, Ground, files_in, read_in

STEP_MM = 1e3 * SPACING
RANDOM = settings(derandomize=True, suppress_health_check=[HealthCheck.function_scoped_fixture])


@pytest.fixture(scope="module")
def wall():
    """A wall of 20 x 26 cells [mm] on a plane: rows cannot be taken for columns."""
    heights = 1e3 * jc.wall_pair(9.0, (20, 26), SPACING, seed=5, roll_off=None)[0]
    return heights + 0.02 * np.arange(26) - 0.01 * np.arange(20)[:, None] + 3.0


def refused(printed, path, **given):
    """That a file is refused in one line that says this and has none of its bytes; the line."""
    with pytest.raises(jc.InputError, match=printed) as error:
        wall_on_grid(read_scan(path, **given), SPACING)
    assert str(error.value).isprintable()
    assert "\\x" not in str(error.value)
    return str(error.value)


def lines_of(wall, mark=" ", scale=(1.0, 1.0, 1.0)):
    return [mark.join(f"{value:.9f}" for value in p) for p in Ground(wall).points() * scale]


@st.composite
def grounds(draw):
    """The upper and the lower wall of a joint in one frame, z upwards."""
    shape = draw(st.integers(20, 28)), draw(st.integers(20, 28))
    step = draw(st.sampled_from([0.25, 0.3, 0.4, 1.0 / 3.0, 1.25]))
    corner = draw(st.tuples(*[st.sampled_from([0.0, 7.5, -30.0, 400.0])] * 2))
    seed = draw(st.integers(0, 1000))
    upper, lower = jc.wall_pair(8.0, shape, 1e-3 * step, seed, correlation=0.9)
    gap = draw(st.sampled_from([0.0, 2.0]))
    return Ground(gap - 1e3 * upper, step, corner), Ground(1e3 * lower, step, corner)


def placed(scan, form):
    """The origin of a scan; an ESRI grid is placed by the corner of its first cell."""
    return None if FORMS[form] is writers.as_esri else scan.origin


@settings(RANDOM, max_examples=3)
@given(grounds())
@pytest.mark.parametrize("form", FORMS)
def test_all_forms_of_a_scan_are_one_scan_in_metres(tmp_path, form, walls):
    for ground in walls:
        scan = read_in(form, ground, tmp_path)
        assert isinstance(scan, Scan)
        assert scan.spacing == pytest.approx((1e-3 * ground.step,) * 2, rel=1e-6)
        atol = 1e-8 if form in ("a.obj", "text.ply") else 2e-9
        np.testing.assert_allclose(scan.heights, 1e-3 * ground.heights, atol=atol)
        if origin := placed(scan, form):
            expected = [1e-3 * part for part in ground.corner]
            assert origin == pytest.approx(expected, rel=1e-6, abs=1e-12)


@pytest.mark.parametrize("form", ["a.npy", "a.nc", "a.xyz", "geo.tiff", "a.asc"])
def test_cells_that_were_not_seen_stay_missing(form, wall, tmp_path):
    holed = wall.copy()
    holed[3:6, 10:14] = np.nan
    found = read_in(form, Ground(holed), tmp_path)
    np.testing.assert_allclose(found.heights, 1e-3 * holed, atol=1e-9)


def cut_off(draw, content):
    """The file up to the end of a word, at least a half of it."""
    ends = [match.end() for match in re.finditer(rb"\S\s", content)]
    return content[: draw(st.sampled_from(ends[len(ends) // 2 :])) - 1]


def one_lost_and_one_doubled(draw, content):
    """One number is lost in a line, and perhaps one is doubled in a later line."""
    lines = content.split(b"\n")
    data = [k for k, line in enumerate(lines) if len(re.findall(rb"\d\.\d", line)) > 1]
    lost, doubled = sorted(draw(st.sets(st.sampled_from(data), min_size=2, max_size=2)))
    for number, word in [(lost, b"")] + [(doubled, None)] * draw(st.booleans()):
        words = re.split(rb"([ ,;]+)", lines[number])
        at = 2 * draw(st.integers(0, (len(words) - 1) // 2))
        words[at : at + 2] = words[at : at + 2] * 2 if word is None else []
        lines[number] = b"".join(words)
    return b"\n".join(lines)


TEXTS = ["a.obj", "text.ply", "a.txt", "a.asc", "esri.txt"]
DISTORTIONS = {cut_off: sorted(FORMS), one_lost_and_one_doubled: TEXTS}


@settings(RANDOM, max_examples=50)
@given(st.data(), grounds(), st.sampled_from(list(DISTORTIONS)))
def test_a_distorted_file_has_no_other_heights_or_is_an_error(tmp_path, data, walls, distort):
    ground, form = walls[1], data.draw(st.sampled_from(DISTORTIONS[distort]))
    given = FORMS[form](tmp_path / form, ground)
    files = files_in(form, tmp_path)
    part = data.draw(st.sampled_from(files))
    part.write_bytes(distort(data.draw, part.read_bytes()))
    try:
        scan = read_scan(files if len(files) > 1 else files[0], **given)
    except jc.InputError:
        return
    assert isinstance(scan, Scan)
    assert scan.spacing == pytest.approx((1e-3 * ground.step,) * 2, rel=1e-6)
    origin = placed(scan, form)
    place = np.zeros(2) if origin is None else (1e3 * np.array(origin) - ground.corner)
    rows, columns = (
        np.round(np.arange(size) + start / ground.step)
        for size, start in zip(scan.heights.shape, place, strict=True)
    )
    written = pd.DataFrame(1e-3 * ground.heights).reindex(index=rows, columns=columns)
    off = np.isfinite(scan.heights) & ~np.isclose(scan.heights, written, rtol=0.0, atol=1e-8)
    assert off.sum() <= 1, (form, scan.remarks)  # a number that lost its end


@pytest.mark.parametrize("form", [*FORMS, "scan.x3p", "scan.unknown"])
@pytest.mark.parametrize("damage", ["truncated", "empty", "noise", "without heights"])
def test_a_damaged_file_is_one_clear_error(form, damage, wall, tmp_path):
    files, given = files_in(form, tmp_path), {"units": "mm"}
    if form in FORMS:
        heights = np.full(wall.shape, np.nan) if damage == "without heights" else wall
        given = FORMS[form](tmp_path / form, Ground(heights))
    whole = files[0].read_bytes() if form in FORMS else b"\x00" * 1000
    noise = np.random.default_rng(3).integers(0, 256, 500, dtype=np.uint8).tobytes()
    cut = whole[:9] if form.endswith(("csv", "xyz", "asc", "txt")) else whole[: len(whole) // 3]
    files[0].write_bytes({"truncated": cut, "empty": b"", "noise": noise}.get(damage, whole))
    refused(files[0].name, files if len(files) > 1 else files[0], **given)


@pytest.mark.parametrize("name", ["a.npy", "a.npz"])
def test_a_pickle_is_refused_and_not_run(name, tmp_path):
    class Trap:
        def __reduce__(self):
            return (exec, (f"open({str(tmp_path / 'sprung')!r}, 'w')",))

    path, given = tmp_path / name, {"units": "mm", "scan_spacing": SPACING}
    trapped = np.array([[Trap(), 0.0, 0.0], [0.0, 1.0, 0.0], [2.0, 3.0, 0.0]], dtype=object)
    np.save(path, trapped) if name == "a.npy" else np.savez(path, Z_mm=trapped)
    refused(rf"{name}: .*(allow_pickle|type object)", path, **given)
    path.write_bytes(pickle.dumps(Trap()))
    refused(rf"{name}: cannot be read as an array", path, **given)
    assert not (tmp_path / "sprung").exists()


@pytest.mark.parametrize(
    ("form", "given", "printed"),
    [
        ("a.npy", {"scan_spacing": SPACING}, "does not state the units of its heights"),
        ("a.npy", {"units": "mm"}, "does not state the spacing"),
        ("a.npy", {"units": "inch", "scan_spacing": SPACING}, "must be one of m, mm, um, nm"),
        ("a.npz", {"units": "mm"}, "units = 'mm': the heights of the file are in 'um'"),
        ("a.npz", {"scan_spacing": 2 * SPACING}, "spacing = 0.5 mm: the file states 0.25 mm"),
        ("a.npz", {"variable": "Q"}, "variable = 'Q': must be one of Z_um, spacing_m"),
        ("a.nc", {"units": "mm"}, "units = 'mm': the heights of the file are in 'micrometre'"),
        ("a.nc", {"units": "um"}, "units = 'um': the distances of the file are in 'm'"),
        ("a.csv", {"units": "m"}, "units = 'm': the heights of the file are in 'um'"),
        ("geo.tiff", {"units": "mm"}, "the heights of the file are in 'metre'"),
        ("a.stl", {"units": "mm", "scan_spacing": 5e-4}, "= 0.5 mm: the file states 0.25 mm"),
        ("gwyddion.asc", {"units": "um"}, "units = 'um': the heights of the file are in 'mm'"),
    ],
)
def test_units_and_spacing_are_stated_once(form, given, printed, wall, tmp_path):
    FORMS[form](tmp_path / form, Ground(wall))
    refused(rf"{form}: .*{printed}", tmp_path / form, **given)


def test_text_as_instruments_and_people_write_it_is_read(wall, tmp_path):
    commas, blanks = lines_of(wall, ","), lines_of(wall)
    text = "\n".join(blanks)
    numbered = [f"{i},{line},1" for i, line in enumerate(commas)]
    titled = ["Scan 7", str(len(blanks)), "% by hand", *blanks[:4], "# half", *blanks[4:]]
    written = {
        "doubled header, trailing commas, DOS": "x,y,z\r\nx,y,z\r\n" + ",\r\n".join(commas) + ",",
        "header again in the middle": "\n".join(["x,y,z", *commas[:9], "x,y,z", *commas[9:]]),
        "semicolons and decimal commas": "x;y;z\n" + text.replace(" ", ";").replace(".", ","),
        "tabs": text.replace(" ", "\t"),
        "blanks and decimal commas": text.replace(".", ","),
        "aligned": "\n".join("   " + line.replace(" ", "    ") for line in blanks),
        "commas and blanks": "\n".join(commas).replace(",", " , "),
        "title, count of points, comments": "\n".join(titled),
        "further columns": "\n".join(["id,x,y,z,quality", *numbered]),
        "byte order mark": "\ufeffX,Y,Z\n" + "\n".join(commas),
    }
    path, contents = tmp_path / "a.txt", {what: text.encode() for what, text in written.items()}
    contents["UTF-16"] = ("X,Y,Z\n" + "\n".join(commas)).encode("utf-16")
    for what, content in contents.items():
        path.write_bytes(content)
        found = read_scan(path, units="mm")
        assert isinstance(found, Scan), what
        np.testing.assert_allclose(found.heights, 1e-3 * wall, atol=1e-12, err_msg=what)
        assert found.spacing == pytest.approx((SPACING, SPACING)), what


HEADS = [
    "x_mm,y_mm,z_um", "# x [mm] y [mm] z [um]", "X (mm);Y (mm);Z (µm)", "X, mm;Y, mm;Z, um",
    "X Position [MM];Y Position [MM];Height [UM]",
]  # fmt: skip


@pytest.mark.parametrize("head", HEADS)
def test_a_head_states_the_units_also_as_a_comment(head, wall, tmp_path):
    lines = [head, *lines_of(wall, scale=(1.0, 1.0, 1e3))]
    (tmp_path / "a.txt").write_bytes("\n".join(lines).encode("latin-1"))
    np.testing.assert_allclose(read_scan(tmp_path / "a.txt").heights, 1e-3 * wall, atol=1e-12)


@pytest.mark.parametrize("head", ["", "depth,east,north,height\n"])
@pytest.mark.parametrize("columns", ["2,3,4", "east,north,height"])
def test_columns_are_chosen_by_number_or_name(head, columns, wall, tmp_path):
    lines = [f"7,{line}" for line in lines_of(wall, ",")]
    path, given = tmp_path / "a.csv", {"units": "mm", "variable": columns}
    path.write_text(head + "\n".join(lines))
    if columns[0] == "e" and not head:
        refused("there are numbers from 1 to 4", path, **given)
        return
    found = read_scan(path, **given)
    np.testing.assert_allclose(found.heights, 1e-3 * wall, atol=1e-12)


CORNERS = {"0": " ", "99.5": ",", "nan": "\t", "y/x": " ", "y\\x": ";", "": "\t", "no corner": " "}


@pytest.mark.parametrize("corner", CORNERS)
@pytest.mark.parametrize("falling", [False, True])
def test_a_matrix_framed_by_its_places_is_that_grid(corner, falling, wall, tmp_path):
    x, y = 3.0 + STEP_MM * np.arange(26), 7.0 + STEP_MM * np.arange(20)
    head = [*x.astype(str)] if corner == "no corner" else [corner, *x.astype(str)]
    rows = [[str(at), *(f"{z:.9f}" for z in row)] for at, row in zip(y, wall, strict=True)]
    lines = [CORNERS[corner].join(cells) for cells in [head, *rows[:: -1 if falling else 1]]]
    (tmp_path / "a.txt").write_text("\n".join(lines))
    scan = read_scan(tmp_path / "a.txt", units="mm")
    np.testing.assert_allclose(scan.heights, 1e-3 * wall, atol=1e-12)
    assert scan.spacing == pytest.approx((SPACING, SPACING))
    assert scan.origin == pytest.approx((7e-3, 3e-3))
    assert "were read as x and y" in " ".join(scan.remarks)


def test_a_matrix_with_places_on_one_side_is_refused_and_a_plane_is_heights(wall, tmp_path):
    framed = np.pad(wall, ((1, 0), (1, 0)))
    framed[0, 1:], framed[1:, 0] = STEP_MM * np.arange(26), STEP_MM * np.arange(20)
    for line, part in (("row", framed[:, 1:]), ("column", framed[1:])):
        given = writers.as_matrix(tmp_path / "a.txt", Ground(part))
        refused(f"its first {line} is evenly spaced", tmp_path / "a.txt", **given)
    plane = 0.02 * np.arange(26) - 0.01 * np.arange(20)[:, None]
    scan = read_in("a.txt", Ground(plane), tmp_path)
    np.testing.assert_allclose(scan.heights, 1e-3 * plane, atol=1e-12)


def test_structs_of_a_matlab_file_and_a_mask_beside_heights_are_refused(wall, tmp_path):
    masked = {"Z_mm": wall, "spacing_mm": 0.25, "mask": wall > 3.0}
    np.savez(tmp_path / "masked.npz", **masked)
    scipy.io.savemat(tmp_path / "masked.mat", masked)
    scipy.io.savemat(tmp_path / "struct.mat", {"S": {"Z": wall}})
    refused(r"masked\.npz: .*mask", tmp_path / "masked.npz")
    refused(r"masked\.mat: .*mask", tmp_path / "masked.mat")
    own = "save arrays of S as variables of their own"
    refused(own, tmp_path / "struct.mat", units="mm")


TRIANGLE = np.array([0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0], "<f4").tobytes() + bytes(2)
STL = b"exported".ljust(80) + struct.pack("<I", 4) + TRIANGLE * 4
PLY = (
    b"ply\nformat ascii 1.0\nelement vertex 6\nproperty float x\nproperty float y\n"
    b"property float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n"
    b"0 0 2\n1 0 2\n2 0 2\n2 1 2\n1 1 2\n0 1 2\n3 0 1 2\n"
)
LINES = [b"v 0 0 0", b"v 1 0 0", b"v 0 1 0", b"v 1 1 0"]
OBJ = b"\n".join(LINES[:3]) + b"\n"
REFUSED = {
    "png.stl": (b"\x89PNG\r\n\x1a\n" + bytes(80), "its content is that of a PNG"),
    "1.csv": (b"1 2\n3 4\n", "2 columns that are not named"),
    "3.csv": (b"x,y,z\n1,,3\n", "1 points lack x or y, the first is number 1"),
    "a.obj": (b"v 0 0 0\nv 1 0 x\n", "could not convert string 'x' to float64 at row 1"),
    "b.obj": (OBJ + b"f 1 2 9\n", "vertices 1 to 9, but there are 3 vertices"),
    "d.obj": (b"\n".join([b"# Vertices: 9", *LINES]), "declares 9 vertices, and contains 4"),
    "b.ply": (PLY.rpartition(b"0 1 2\n3")[0], "declares 6 vertices, and contains 5"),
    "e.ply": (PLY.replace(b"3 0 1 2", b"3 0 1 9"), "vertices 1 to 10, but there are 6 vertices"),
    "a.asc": (b"# scan\n" + OBJ + b"f 1 2 3\n", "text must be .txt, .csv or .xyz"),
    "c.grd": (b"DSBB" + struct.pack("<2h6d", 9, 9, *range(6)) + bytes(40), "(c.grd, band 1: IRead"),
    "d.grd": (b"DSBB" + struct.pack("<2h6d", 30_000, 30_000, *range(6)), "at most 800 MB"),
    "a.ply": (STL, "cannot be read as PLY"),
}


@pytest.mark.parametrize("name", REFUSED)
def test_a_file_of_no_form_is_refused_in_one_line_without_its_bytes(name, tmp_path):
    content, printed = REFUSED[name]
    (tmp_path / name).write_bytes(content)
    message = refused(re.escape(printed), tmp_path / name, units="mm")
    assert ("its content" in message) == ("its content" in printed)  # what it is most like


@pytest.mark.parametrize("form", ["a.npy", "x.dat.txt,y.dat.txt,z.dat.txt", "a.tif"])
@pytest.mark.parametrize("sentinel", [-9999.0, 9999.0, 1e30, 0.0])
def test_an_undeclared_sentinel_is_no_height(form, sentinel, wall, tmp_path):
    coded, holed = wall - wall.mean(), wall - wall.mean()  # heights on both sides of 0
    coded[3:6, 10:15], holed[3:6, 10:15] = sentinel, np.nan
    scan = read_in(form, Ground(coded), tmp_path)
    np.testing.assert_allclose(scan.heights, 1e-3 * holed, atol=1e-9)
    remarks = " ".join(scan.remarks)
    assert f"{sentinel:g} were treated as missing" in remarks or sentinel == 0.0
    assert ("Warning: 15 of 520 heights are exactly 0" in remarks) == (sentinel == 0.0)
    assert "15 " in remarks


def test_zeros_that_are_heights_stay(wall, tmp_path):
    rounded = np.round(wall - wall.mean(), 2)  # values come in dozens
    block = np.zeros((20, 26))
    block[4:8, 5:9] = 0.1 * np.arange(16).reshape(4, 4) + 0.1
    for heights in (rounded, block, wall - wall.min()):
        scan = read_in("a.npy", Ground(heights), tmp_path)
        np.testing.assert_allclose(scan.heights, 1e-3 * heights)


@pytest.mark.parametrize("name", ["a.xyz", "a.stl"])
def test_a_stray_point_is_cut_and_named(name, tmp_path):
    points = np.random.default_rng(2).random((2000, 3)) * [10.0, 10.0, 0.1]
    far = np.vstack([points, [1e6, -2e6, 0.05], [4.0, 5.0, 700.0]])
    if name == "a.xyz":
        np.savetxt(tmp_path / name, far)
    else:
        faces = np.arange(len(far)).reshape(-1, 2)
        writers.write_mesh(tmp_path / name, far, np.column_stack([faces, np.roll(faces[:, 0], 1)]))
    scan = read_scan(tmp_path / name, units="mm")
    assert isinstance(scan, Cloud)
    np.testing.assert_allclose(np.sort(scan.points, 0), 1e-3 * np.sort(points, 0), rtol=1e-6)
    printed, scattered = scan.remarks
    assert "Warning: the points lie on no regular grid" in scattered
    assert printed.startswith("2 stray points were cut")
    assert "(1e+06, -2e+06, 0.05), (4, 5, 700)" in printed or name == "a.stl"


def test_points_far_apart_are_refused_before_a_terabyte_is_allocated():
    points = np.random.default_rng(2).random((400, 3)) * [1.0, 1.0, 1e-5]
    points[:200, 1] += 1e6
    points[:, 0] += points[:, 1]
    with pytest.raises(jc.InputError, match="at most 100 cells for each point"):
        wall_on_grid(Cloud(points), point_distance(Cloud(points)))


def test_a_grid_is_placed_by_a_corner_and_one_of_esri_may_have_dx_and_dy(wall, tmp_path):
    ground = Ground(wall, STEP_MM, (5.0, 3.0))
    writers.as_geotiff(tmp_path / "a.tif", ground, placed=1)
    from_top = read_scan(tmp_path / "a.tif").origin
    assert from_top == pytest.approx((5e-3 - 0.5 * SPACING, 3e-3 + 0.5 * SPACING))
    usual = read_in("a.asc", ground, tmp_path)
    assert usual.origin == pytest.approx((5e-3 + 0.5 * SPACING, 3e-3 + 0.5 * SPACING))
    writers.as_esri(tmp_path / "b.asc", ground, cellsize=None, dx=STEP_MM, dy=STEP_MM)
    of_gdal = read_scan(tmp_path / "b.asc", units="mm")
    np.testing.assert_array_equal(of_gdal.heights, usual.heights)
    assert (of_gdal.spacing, of_gdal.origin) == (usual.spacing, usual.origin)
    writers.as_esri(tmp_path / "b.asc", ground, cellsize=None, dx=STEP_MM, dy=2.0 * STEP_MM)
    tall = read_scan(tmp_path / "b.asc", units="mm")
    assert tall.spacing == pytest.approx((2.0 * SPACING, SPACING))
    assert tall.origin == pytest.approx((5e-3 + SPACING, 3e-3 + 0.5 * SPACING))


@pytest.mark.parametrize(
    ("rows", "head", "printed"),
    [
        (12, {}, "declares 20 rows of 26 heights, 520, and contains 312"),
        (None, {"cellsize": None}, "header lacks cellsize"),
        (None, {"nrows": 10**9}, "at most 800 MB"),
        (None, {"nrows": 20.5}, "nrows = 20.5: must be a whole number"),
        (None, {"dx": 0.5}, r"spacings \(y, x\): cellsize 0.25 x 0.25; dx 0.5; must be the same"),
        (None, {"cellsize": None, "dx": 0.25}, "header lacks cellsize, or both dx and dy"),
    ],
)
def test_an_esri_grid_that_is_not_what_it_declares_is_refused(rows, head, printed, wall, tmp_path):
    writers.as_esri(tmp_path / "a.asc", Ground(wall), rows, **head)
    assert "rename" not in refused(rf"a\.asc: .*{printed}", tmp_path / "a.asc", units="mm")


def test_the_blank_value_of_a_surfer_7_grid_is_no_height(wall, tmp_path):
    (tmp_path / "a.grd").write_bytes(writers.surfer_7(wall, 0.3, blank=wall[4, 5]))
    scan = read_scan(tmp_path / "a.grd", units="mm")
    np.testing.assert_array_equal(np.isnan(scan.heights), wall == wall[4, 5])


@pytest.mark.parametrize(
    ("names", "shown"), [("xz", "must be one file, or three"), ("xyz", "20 x 26, 3 x 4, 20 x 26")]
)
def test_two_matrices_and_three_of_different_shapes_are_refused(names, shown, wall, tmp_path):
    given = writers.as_three_files(tmp_path / "a", Ground(wall))
    np.savetxt(tmp_path / "y.dat.txt", np.ones((3, 4)))
    refused(shown, ",".join(str(tmp_path / f"{name}.dat.txt") for name in names), **given)


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
    places = {
        dim: (dim, STEP_MM * np.arange(size), {"units": "mm"} | about)
        for dim, size, about in zip(dims, wall.shape, attributes, strict=True)
    }
    dataset = xr.Dataset({"height": (dims, wall, {"units": "mm"})}, places)
    if dims[0] != "first":
        dataset = dataset.transpose(*dims[::-1])
    dataset.to_netcdf(tmp_path / "a.nc", engine="netcdf4")
    scan = read_scan(tmp_path / "a.nc")
    np.testing.assert_allclose(scan.heights, 1e-3 * wall)
    assert any("read as y, x" in remark for remark in scan.remarks) == (dims[0] == "first")


def test_an_archive_that_declares_more_than_a_scan_is_refused_unread(wall, tmp_path):
    """Zeros are packed a thousand times: of a bomb nothing but the head may be read."""
    path, stated = tmp_path / "a.npz", {"units": "mm", "scan_spacing": SPACING}
    np.savez(path, Z_mm=wall, spacing_mm=STEP_MM)
    heads = {"other": ("<f8", (40_000, 25_000)), "item": ("|V300000000", (3, 3))}
    with zipfile.ZipFile(path, "a") as archive:
        for name, (kind, shape) in heads.items():
            head = io.BytesIO()
            declared = {"descr": kind, "fortran_order": False, "shape": shape}
            np.lib.format.write_array_header_1_0(head, declared)
            archive.writestr(f"{name}.npy", head.getvalue())
            (tmp_path / f"{name}.npy").write_bytes(head.getvalue())
    assert read_scan(path, variable="Z_mm").heights.shape == wall.shape
    size = r"declares 40000 x 25000 values of 8 bytes: must be at most 800 MB"
    refused(size, tmp_path / "other.npy", **stated)
    refused(size, path, variable="other", **stated)
    refused(r"item: values of type \|V300000000: must be", path, variable="item", **stated)


@pytest.mark.parametrize("name", ["a.csv", "a.asc", "a.stl", "a.sur", "a"])
def test_a_file_too_large_to_be_read_as_a_whole_is_one_error(name, tmp_path):
    with (tmp_path / name).open("wb") as file:  # sparse: it takes no room on the disk
        file.write(b"0 0 0\n")
        file.truncate(20_000_000_000)
    refused(rf"{name}: 20 GB: must be at most 2 GB", tmp_path / name, units="mm")


@pytest.mark.parametrize(
    ("bands", "turned", "printed"),
    [(1, 0.0, None), (1, 0.1, "turned or mirrored"), (2, 0.0, "an image of 2 bands")],
)
def test_packed_pixels_are_heights_if_of_one_image(bands, turned, printed, wall, tmp_path):
    rasterio, path = pytest.importorskip("rasterio"), tmp_path / "a.tif"
    micrometres = np.round(1e3 * wall)
    place = rasterio.Affine(0.25, turned, 0.0, -turned, 0.25, 0.0)
    about = {"driver": "GTiff", "width": 26, "height": 20, "count": bands, "transform": place}
    with rasterio.open(path, "w", **about, dtype="int16", compress="lzw") as file:
        file.write(micrometres.astype("i2"), 1)
        file.scales = [1e-3] * bands
    if printed is None:
        np.testing.assert_allclose(read_scan(path, units="mm").heights, 1e-6 * micrometres)
    else:
        refused(printed, path, units="mm")

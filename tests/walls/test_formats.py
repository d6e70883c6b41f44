"""Each form gives back the wall that was written, or says what is wrong with the file."""

import io
import pickle
import re
import struct
import tracemalloc
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
from jointclosure.walls.registration import registered
from jointclosure.walls.scans import contents, read_scan
from tests.joints import SPACING
from tests.walls import writers
from tests.walls.writers import FORMS, Ground, files_in, read_in, triangles

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
def test_a_pickle_is_refused_before_it_runs(name, tmp_path):
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
        (
            "a.npy",
            {"units": "cm", "scan_spacing": SPACING},
            "must be one of m, mm, um, nm, inch; convert others, such as cm",
        ),
        ("a.npz", {"units": "mm"}, "units = 'mm': the heights of the file are in 'um'"),
        ("a.npz", {"scan_spacing": 2 * SPACING}, "spacing = 0.5 mm: the file states 0.25 mm"),
        ("a.npz", {"variable": "Q"}, "variable = 'Q': must be one of Z_um, spacing_m"),
        ("a.nc", {"units": "mm"}, "units = 'mm': the heights of the file are in 'micrometre'"),
        ("a.nc", {"units": "um"}, "units = 'um': the distances of the file are in 'm'"),
        (
            "a.csv",
            {"units": "m"},
            "units = 'm': the heights of the file are in 'um'; leave the units out",
        ),
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


STATEMENTS = [
    "# Channel: Z\n# Width: 6.5 mm\n# Height: 5 mm\n# Value units: mm",
    "# Width: 6500 µm\n# Height: 5 mm\n# Value units: mm",
    "Width:\t6.5 mm\nHeight:\t5 mm\nUnits:\tmm",
    '"XY Calibration","250","um"\n"Horizontal","26"\n"Vertical","20"\n"Unit","mm"',
    "Scan of joint 7, by hand\nRows\t20\nColumns\t26\nStep (mm): 0.25\nUnits: mm",
    "# dx = 0.25 mm, dy = 0.25 mm\n# z-unit mm",
]


@pytest.mark.parametrize("name", ["a.txt", "a.asc", "a.dat"])
@pytest.mark.parametrize("statement", STATEMENTS)
def test_the_header_of_a_matrix_states_units_and_spacing(statement, name, wall, tmp_path):
    rows = [" ".join(f"{value:.9f}" for value in row) for row in wall]
    (tmp_path / name).write_text("\n".join([statement, *rows]))
    scan = read_scan(tmp_path / name)
    np.testing.assert_allclose(scan.heights, 1e-3 * wall, atol=1e-12)
    assert scan.spacing == pytest.approx((SPACING, SPACING))


@pytest.mark.parametrize("stated", ["units", "header", "plural"])
def test_a_scan_in_inches_is_read(stated, wall, tmp_path):
    head = {"units": [], "header": ["# Units: inch"], "plural": ["# Units: inches"]}[stated]
    rows = [" ".join(f"{value:.12f}" for value in row) for row in wall / 25.4]
    (tmp_path / "a.txt").write_text("\n".join([*head, *rows]))
    given = {"units": "inch"} if stated == "units" else {}
    scan = read_scan(tmp_path / "a.txt", scan_spacing=SPACING, **given)
    np.testing.assert_allclose(scan.heights, 1e-3 * wall, atol=1e-12)


CONTRADICTIONS = {
    "Units: um": "units = 'mm': the heights of the file are in 'um'",
    "Value units: foot": "units = 'foot': must be one of m, mm, um, nm, inch",
    "Value units: inch": "units = 'mm': the heights of the file are in 'inch'",
    "Units: mm\n# Value units: um": "states the units 'mm' and 'um'; must be the same",
    "Step: 0.3 mm": "the file states 0.3 mm; must be left out",
    "Width: 7 mm\n# dx: 0.25 mm": "states different spacings",
    "Rows: 21": "the file states 21 rows; there are 20",
    "Scale factor: 1000": "heights must be stored without a factor",
    "Pixel size: 0 mm": "must be positive and finite",
}


@pytest.mark.parametrize("statement", CONTRADICTIONS)
@pytest.mark.parametrize("place", ["above", "below"])
def test_a_statement_of_a_header_that_cannot_be_true_is_refused(statement, place, wall, tmp_path):
    rows = [" ".join(f"{value:.9f}" for value in row) for row in wall]
    lines = [f"# {statement}", *rows] if place == "above" else [*rows, f"# {statement}"]
    (tmp_path / "a.txt").write_text("\n".join(lines))
    given = {"units": "mm", "scan_spacing": SPACING}
    refused(re.escape(CONTRADICTIONS[statement]), tmp_path / "a.txt", **given)


@pytest.mark.parametrize(
    ("head", "printed"),
    [
        ("# Units: um", "units = 'mm': the heights of the file are in 'um'"),
        ("# Units: um\nx_mm y_mm z_mm", "column of x: states the units 'mm' and 'um'"),
        ("# spacing: 0.3 mm", "states different spacings"),
        ("x_cm y_cm z_cm", "units = 'cm': must be one of"),
        ("x (in) y (in) z (in)", "units = 'in': must be one of"),
    ],
)
def test_a_statement_above_points_that_cannot_be_true_is_refused(head, printed, wall, tmp_path):
    (tmp_path / "a.xyz").write_text("\n".join([head, *lines_of(wall)]))
    refused(re.escape(printed), tmp_path / "a.xyz", units="mm")


def test_a_statement_that_is_not_understood_is_named(wall, tmp_path):
    (tmp_path / "a.xyz").write_text("\n".join(["# heights in um, x in mm", *lines_of(wall)]))
    unread = "'heights in um, x in mm'"
    refused(rf"in words that are understood \({unread}\): give units", tmp_path / "a.xyz")
    remarks = " ".join(read_scan(tmp_path / "a.xyz", units="mm").remarks)
    assert f"{unread}, which was not used" in remarks


@pytest.mark.parametrize("name", ["a.asc", "a.dat", "a.pts", "a.prn", "a"])
def test_text_of_any_name_is_read_as_points_or_as_a_matrix(name, wall, tmp_path):
    (tmp_path / name).write_text("\n".join(lines_of(wall)))
    scan = read_scan(tmp_path / name, units="mm")
    np.testing.assert_allclose(scan.heights, 1e-3 * wall, atol=1e-12)
    np.savetxt(tmp_path / name, wall, "%.9f")
    scan = read_scan(tmp_path / name, units="mm", scan_spacing=SPACING)
    np.testing.assert_allclose(scan.heights, 1e-3 * wall, atol=1e-12)


def test_a_text_file_of_an_instrument_is_read_by_its_own_rules(wall, tmp_path):
    pytest.importorskip("SurfaceTopography")
    head = "# File Format = ASCII\n# x-pixels = 26\n# y-pixels = 20\n# x-length = 6.5e6\n"
    head += "# y-length = 5e6\n# x-unit = nm\n# y-unit = nm\n# z-unit = nm\n# Start of Data:\n"
    for name in ("a.txt", "a.asc"):
        np.savetxt(tmp_path / name, 1e6 * wall, "%.6f", header=head, comments="")
        scan = read_scan(tmp_path / name)
        np.testing.assert_allclose(scan.heights, 1e-3 * wall, atol=1e-12)
        assert scan.spacing == pytest.approx((SPACING, SPACING))


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


@pytest.mark.parametrize(("line", "part"), [("row", np.s_[:, 1:]), ("column", np.s_[1:])])
def test_a_matrix_with_places_on_one_side_is_refused(line, part, wall, tmp_path):
    framed = np.pad(wall, ((1, 0), (1, 0)))
    framed[0, 1:], framed[1:, 0] = STEP_MM * np.arange(26), STEP_MM * np.arange(20)
    given = writers.as_matrix(tmp_path / "a.txt", Ground(framed[part]))
    refused(f"its first {line} is evenly spaced", tmp_path / "a.txt", **given)


def test_a_matrix_that_is_a_plane_is_heights(tmp_path):
    plane = 0.02 * np.arange(26) - 0.01 * np.arange(20)[:, None]
    scan = read_in("a.txt", Ground(plane), tmp_path)
    np.testing.assert_allclose(scan.heights, 1e-3 * plane, atol=1e-12)


@pytest.mark.parametrize(
    ("name", "save"), [("masked.npz", np.savez), ("masked.mat", scipy.io.savemat)]
)
def test_a_mask_beside_heights_is_refused(name, save, wall, tmp_path):
    arrays = {"Z_mm": wall, "spacing_mm": 0.25, "mask": wall > 3.0}
    save(tmp_path / name, **arrays) if save is np.savez else save(tmp_path / name, arrays)
    refused(rf"{name}: .*mask", tmp_path / name)


def test_structs_of_a_matlab_file_are_refused(wall, tmp_path):
    scipy.io.savemat(tmp_path / "struct.mat", {"S": {"Z": wall}})
    own = "save arrays of S as variables of their own"
    refused(own, tmp_path / "struct.mat", units="mm")


@pytest.mark.parametrize(
    ("name", "comment"),
    [
        ("a.obj", "# Units: um\n"),
        ("text.ply", "comment units: um\n"),
        ("a.ply", "obj_info Units = micrometre\n"),
        ("a.stl", "units: um"),
    ],
)
def test_a_comment_of_a_mesh_states_its_units(name, comment, wall, tmp_path):
    path = tmp_path / name
    writers.as_mesh(path, Ground(wall))
    content, added = path.read_bytes(), comment.encode()
    if name == "a.stl":
        path.write_bytes(added.ljust(80) + content[80:])
    elif name == "a.obj":
        path.write_bytes(added + content)
    else:
        path.write_bytes(content.replace(b"element vertex", added + b"element vertex", 1))
    np.testing.assert_allclose(read_scan(path).heights, 1e-6 * wall, atol=1e-11)
    refused("units = 'mm': the heights of the file are in 'u?m", path, units="mm")


@pytest.mark.parametrize(
    ("about", "unit", "printed"),
    [
        ("ImageJ=1.53t\nunit=mm\n", 1, None),
        ("a camera", 2, "4 x 4 pixels per inch', which was not"),
    ],
)
def test_the_resolution_of_a_tiff_is_used_or_named(about, unit, printed, wall, tmp_path):
    pytest.importorskip("rasterio")
    path = tmp_path / "a.tif"
    pytest.importorskip("tifffile").imwrite(
        path, wall, resolution=(4.0, 4.0), resolutionunit=unit, description=about, metadata=None
    )
    given = {"scan_spacing": SPACING} if printed else {}
    scan = read_scan(path, units="mm", **given)
    assert scan.spacing == pytest.approx((SPACING, SPACING))
    assert (printed or "") in " ".join(scan.remarks)


def test_files_beside_a_tiff_are_not_read(wall, tmp_path):
    given = FORMS["a.tif"](tmp_path / "a.tif", Ground(wall))
    (tmp_path / "a.tfw").write_text("0.5\n0\n0\n-0.5\n0\n0\n")
    band = "<PAMRasterBand band='1'><Scale>2</Scale></PAMRasterBand>"
    (tmp_path / "a.tif.aux.xml").write_text(f"<PAMDataset>{band}</PAMDataset>")
    scan = read_scan(tmp_path / "a.tif", **given)
    np.testing.assert_allclose(scan.heights, 1e-3 * wall)
    assert scan.spacing == pytest.approx((SPACING, SPACING))


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
    "a.asc": (b"# scan\n" + OBJ + b"f 1 2 3\n", "has no line of numbers"),
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


@pytest.mark.parametrize("form", ["a.npy", "x.dat.txt,y.dat.txt,z.dat.txt"])
@pytest.mark.parametrize("touching", [0.1, 0.2])
def test_zeros_of_an_aperture_map_are_contacts(form, touching, tmp_path):
    summed = sum(jc.wall_pair(8.0, (40, 50), SPACING, 3, mismatch_wavelength=1e-3))
    aperture = 1e3 * np.maximum(np.quantile(summed, 1.0 - touching) - summed, 0.0)
    scan = read_in(form, Ground(aperture), tmp_path)
    np.testing.assert_allclose(scan.heights, 1e-3 * aperture, atol=1e-9)
    assert "they were used as contacts of an aperture map" in " ".join(scan.remarks)
    pair = registered(scan, "flat", orientation="common_frame")
    assert not pair.holes.any()


def test_zeros_beside_heights_that_are_not_small_are_missing(tmp_path):
    wall = 1e3 * jc.wall_pair(8.0, (40, 50), SPACING, 3)[0]
    coded = wall - wall.min()
    coded[5:9, 10:15] = coded[25:31, 30:33] = 0.0
    scan = read_in("a.npy", Ground(coded), tmp_path)
    np.testing.assert_array_equal(np.isnan(scan.heights), coded == 0.0)


POINTS = np.random.default_rng(2).random((2000, 3)) * [10.0, 10.0, 0.1]


@pytest.fixture(params=["a.xyz", "a.stl"])
def strayed(request, tmp_path):
    """Name and scan of a file of points of which two lie far from all others."""
    name = request.param
    far = np.vstack([POINTS, [1e6, -2e6, 0.05], [4.0, 5.0, 700.0]])
    if name == "a.xyz":
        np.savetxt(tmp_path / name, far)
    else:
        faces = np.arange(len(far)).reshape(-1, 2)
        writers.write_mesh(tmp_path / name, far, np.column_stack([faces, np.roll(faces[:, 0], 1)]))
    return name, read_scan(tmp_path / name, units="mm")


def test_a_stray_point_is_cut(strayed):
    _, scan = strayed
    assert isinstance(scan, Cloud)
    np.testing.assert_allclose(np.sort(scan.points, 0), 1e-3 * np.sort(POINTS, 0), rtol=1e-6)


def test_a_stray_point_is_named(strayed):
    name, scan = strayed
    printed, scattered = scan.remarks
    assert "Warning: the points lie on no regular grid" in scattered
    assert printed.startswith("2 stray points were cut")
    assert "(1e+06, -2e+06, 0.05), (4, 5, 700)" in printed or name == "a.stl"


@pytest.fixture(scope="module")
def both_walls():
    """Points (n, 3) [mm] of the lower and the upper wall of a joint at first touch, and a grid."""
    upper, lower = (1e3 * wall for wall in jc.wall_pair(8.0, (40, 40), SPACING, seed=4))
    above = (upper + lower).max() - upper
    return Ground(lower).points(), Ground(above).points()


def scattered(points, seed=3):
    off = np.random.default_rng(seed).uniform(-0.1, 0.1, (len(points), 2))
    return points + np.column_stack([off, np.zeros(len(points))])


COLUMNS = {"x": ([2, 0, 1], "2,3,1"), "y": ([1, 2, 0], "3,1,2")}


@pytest.mark.parametrize("form", ["a.xyz", "a.stl"])
@pytest.mark.parametrize("axis", COLUMNS)
@pytest.mark.parametrize("flat", [False, True])
def test_a_vertical_wall_is_refused_with_the_columns_that_turn_it(
    form, axis, flat, both_walls, tmp_path
):
    level, (order, columns) = both_walls[0] * [1.0, 1.0, not flat], COLUMNS[axis]
    path = tmp_path / form
    if form == "a.xyz":
        np.savetxt(path, level[:, order], "%.6f")
    else:
        writers.write_mesh(path, level[:, order], triangles((40, 40)))
    refused(rf"heights of the wall lie along {axis}, .*variable = '{columns}'", path, units="mm")
    scan = read_scan(path, units="mm", variable=columns)
    np.testing.assert_allclose(scan.heights.ravel(), 1e-3 * level[:, 2], atol=1e-8)


@pytest.mark.parametrize("gap", [0.0, 0.5, 30.0])
@pytest.mark.parametrize("on_nodes", [False, True])
def test_both_walls_in_one_cloud_are_refused(gap, on_nodes, both_walls, tmp_path):
    lower, upper = both_walls
    lower = lower if on_nodes else scattered(lower)
    both = np.vstack([lower, scattered(upper + np.array([0.0, 0.0, gap]), seed=5)])
    np.savetxt(tmp_path / "a.xyz", both, "%.6f")
    refused("two sheets above each other.*must be cut to one wall", tmp_path / "a.xyz", units="mm")


def test_walls_beside_each_other_in_one_cloud_are_refused(both_walls, tmp_path):
    both = np.vstack([both_walls[0], both_walls[1] + [15.0, 0.0, 0.0]])
    np.savetxt(tmp_path / "a.xyz", both, "%.6f")
    refused("separate patches, of 1600 and 1600 points", tmp_path / "a.xyz", units="mm")


@pytest.mark.parametrize("on_nodes", [False, True])
def test_the_points_of_a_block_are_refused(on_nodes, both_walls, tmp_path):
    top = both_walls[0] + [0.0, 0.0, 12.0]
    random = np.random.default_rng(6)
    sides = random.random((2000, 3)) * [9.75, 9.75, 12.0]
    face = random.integers(0, 4, 2000)
    sides[face < 2, 0], sides[face >= 2, 1] = 9.75 * (face[face < 2]), 9.75 * (face[face >= 2] - 2)
    block = np.vstack([top if on_nodes else scattered(top), sides])
    np.savetxt(tmp_path / "a.xyz", block, "%.6f")
    refused("far above or below them.*must be cut to one wall", tmp_path / "a.xyz", units="mm")


def test_one_wall_is_no_pair_of_sheets_whatever_its_heights(both_walls, tmp_path):
    points = scattered(both_walls[0])
    noise = np.random.default_rng(1).random(len(points))
    walls = {"rough": points[:, 2], "rounded": np.round(points[:, 2], 1), "noise": 0.1 * noise}
    for what, heights in walls.items():
        np.savetxt(tmp_path / "a.xyz", np.column_stack([points[:, :2], heights]), "%.6f")
        assert len(read_scan(tmp_path / "a.xyz", units="mm").points) == 1600, what


@pytest.mark.parametrize("far", [4.5e6])
def test_a_mesh_too_far_from_its_origin_for_single_precision_is_refused(far, tmp_path):
    wall = 1e3 * jc.wall_pair(8.0, (20, 26), SPACING, seed=4)[0]
    writers.as_mesh(tmp_path / "a.stl", Ground(wall, 0.26, (far, 0.0)))
    printed = "y is stored in single precision, .* too far from its origin"
    refused(printed, tmp_path / "a.stl", units="mm")


def test_a_mesh_whose_places_are_exact_in_single_precision_is_read(tmp_path):
    """At 450 m single precision in mm has steps of 1/32 mm, of which 0.25 mm is a multiple."""
    wall = 1e3 * jc.wall_pair(8.0, (20, 26), SPACING, seed=4)[0]
    writers.as_mesh(tmp_path / "a.stl", Ground(wall, 0.25, (4.5e5, 0.0)))
    scan = read_scan(tmp_path / "a.stl", units="mm")
    assert scan.spacing == pytest.approx((SPACING, SPACING), rel=1e-6)
    np.testing.assert_allclose(scan.heights, 1e-3 * wall, atol=1e-9)


@pytest.mark.parametrize("form", ["a.npy", "a.tif"])
def test_heights_too_far_from_zero_for_single_precision_are_refused(form, wall, tmp_path):
    """At a height of 2 km single precision in mm has steps of 0.125 mm."""
    ground = Ground(np.float32(wall + 2e6))
    refused(
        "z is stored in single precision", tmp_path / form, **FORMS[form](tmp_path / form, ground)
    )
    read_in(form, Ground(np.float32(wall + 1e3)), tmp_path)


def test_points_far_apart_are_refused_before_a_terabyte_is_allocated():
    points = np.random.default_rng(2).random((400, 3)) * [1.0, 1.0, 1e-5]
    points[:200, 1] += 1e6
    points[:, 0] += points[:, 1]
    with pytest.raises(jc.InputError, match="at most 100 cells for each point"):
        wall_on_grid(Cloud(points), point_distance(Cloud(points)))


CORNER = (5.0, 3.0)


def test_a_geotiff_may_be_placed_by_a_corner(wall, tmp_path):
    writers.as_geotiff(tmp_path / "a.tif", Ground(wall, STEP_MM, CORNER), placed=1)
    from_top = read_scan(tmp_path / "a.tif").origin
    assert from_top == pytest.approx((5e-3 - 0.5 * SPACING, 3e-3 + 0.5 * SPACING))


def test_an_esri_grid_is_placed_by_a_corner(wall, tmp_path):
    usual = read_in("a.asc", Ground(wall, STEP_MM, CORNER), tmp_path)
    assert usual.origin == pytest.approx((5e-3 + 0.5 * SPACING, 3e-3 + 0.5 * SPACING))


def test_an_esri_grid_may_state_both_steps(wall, tmp_path):
    ground = Ground(wall, STEP_MM, CORNER)
    usual = read_in("a.asc", ground, tmp_path)
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
def test_matrices_other_than_three_of_one_shape_are_refused(names, shown, wall, tmp_path):
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


def test_a_scan_is_read_in_three_times_the_memory_of_its_heights(tmp_path):
    heights = np.random.default_rng(1).normal(size=(1000, 1000))
    np.savez(tmp_path / "a.npz", Z_mm=heights, spacing_mm=STEP_MM)
    tracemalloc.start()
    try:
        read_scan(tmp_path / "a.npz")
        assert tracemalloc.get_traced_memory()[1] < 3.0 * heights.nbytes
    finally:
        tracemalloc.stop()


def test_the_limit_of_an_array_is_that_of_its_doubles(tmp_path, monkeypatch):
    monkeypatch.setattr(contents, "LARGEST_ARRAY", 100_000)
    np.save(tmp_path / "a.npy", np.arange(14_400, dtype=np.int16).reshape(120, 120))
    printed = "120 x 120 values of 2 bytes, which are read in double precision: must be at most"
    refused(printed, tmp_path / "a.npy", units="mm", scan_spacing=SPACING)


ELSEWHERE = {
    "external storage": lambda file, other, kind: file.create_dataset(
        "z_mm", (20, 26), "f8", external=[(str(other.with_suffix(".bin")), 0, 4160)]
    ),
    "an external link": lambda file, other, kind: file.__setitem__(
        "z_mm", kind.ExternalLink(str(other), "/z_mm")
    ),
    "a virtual dataset": lambda file, other, kind: file.create_virtual_dataset(
        "z_mm", _virtual(kind, other)
    ),
}


def _virtual(h5py, other):
    layout = h5py.VirtualLayout((20, 26), "f8")
    layout[:] = h5py.VirtualSource(str(other), "z_mm", (20, 26))
    return layout


@pytest.mark.parametrize("name", ["a.nc", "a.h5", "a"])
@pytest.mark.parametrize("version", ["earliest", "latest"])
@pytest.mark.parametrize("what", ELSEWHERE)
@pytest.mark.parametrize("block", [0, 1024])
def test_an_hdf5_file_with_data_in_another_file_is_refused(
    what, version, name, block, wall, tmp_path
):
    h5py, other = pytest.importorskip("h5py"), tmp_path / "other.h5"
    other.with_suffix(".bin").write_bytes(wall.tobytes())
    with h5py.File(other, "w") as file:
        file["z_mm"] = wall
    with h5py.File(tmp_path / name, "w", libver=version, userblock_size=block) as file:
        for number in range(20):
            file[f"number_{number}"] = number
        file["spacing_mm"] = 0.25
        ELSEWHERE[what](file, other, h5py)
    refused(f"has {what}, so that heights would be read from another file", tmp_path / name)


def test_an_hdf5_file_that_contains_its_data_is_read(wall, tmp_path):
    h5py = pytest.importorskip("h5py")
    with h5py.File(tmp_path / "a.nc", "w") as file:
        file["z_mm"], file["spacing_mm"] = wall, 0.25
        file["again"] = h5py.SoftLink("/spacing_mm")
        file.attrs["names"] = ["a", "b"]  # in a global heap
    np.testing.assert_allclose(read_scan(tmp_path / "a.nc").heights, 1e-3 * wall)


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


def test_a_missing_column_is_named(tmp_path):
    path = tmp_path / "two.csv"
    path.write_text("x (mm),y (mm)\n" + "1.0,2.0\n2.0,3.0\n" * 20)
    refused(r"columns x \(mm\), y \(mm\): z is missing; must be named x, y and z", path)


def test_a_small_grid_is_told_from_points(tmp_path):
    path = tmp_path / "small.txt"
    np.savetxt(path, np.random.default_rng(1).random((4, 4)))
    refused("a grid of heights, it must have at least 12 columns", path, units="mm")

"""All forms of a scan are one joint, and a slip of units is refused or warned of at every door."""

import re
import struct
import warnings
from pathlib import Path

import numpy as np
import pytest
import scipy.io
import xarray as xr
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import jointclosure as jc
from jointclosure.engine.choice import choose_effects
from jointclosure.engine.settings import Walls
from jointclosure.plotting.walls import pair_figure
from jointclosure.walls.measured import Scan
from jointclosure.walls.registration import registered
from jointclosure.walls.scans import read_scan
from studies.frame.ensemble.walls import prepared_walls
from tests.joints import DOLERITE, SPACING
from tests.walls.test_formats import triangles, write_esri

RANDOM = settings(
    max_examples=20,
    deadline=None,
    derandomize=True,
    suppress_health_check=[HealthCheck.function_scoped_fixture],
)


class Ground:
    """A wall (y, x) [mm] on a grid, to be written in every form."""

    def __init__(self, heights: np.ndarray, step: float, corner: tuple[float, float]):
        self.heights, self.step, self.corner = heights, step, corner

    def points(self) -> np.ndarray:
        y, x = np.indices(self.heights.shape) * self.step
        x, y = x + self.corner[1], y + self.corner[0]
        return np.stack([x.ravel(), y.ravel(), self.heights.ravel()], axis=1)


def as_npy(path, ground):
    np.save(path, ground.heights)
    return {"units": "mm", "spacing": 1e-3 * ground.step}


def as_npz(path, ground):
    np.savez(path, Z_um=1e3 * ground.heights, spacing_m=1e-3 * ground.step)
    return {}


def as_netcdf(path, ground):
    ny, nx = ground.heights.shape
    places = {
        axis: (axis, corner + ground.step * np.arange(size), {"units": "mm"})
        for axis, size, corner in zip("yx", (ny, nx), ground.corner, strict=True)
    }
    dataset = xr.Dataset({"z": (("y", "x"), ground.heights, {"units": "mm"})}, places)
    dataset.isel(y=slice(None, None, -1)).transpose("x", "y").to_netcdf(path, engine="netcdf4")
    return {}


def as_csv(path, ground):
    points = ground.points() * [1.0, 1.0, 1e3]
    np.savetxt(path, points, "%.6f", ",", header="x,y,z\nmm,mm,um", comments="")
    return {}


def as_shuffled_text(path, ground):
    points = np.random.default_rng(1).permutation(ground.points())
    np.savetxt(path, np.vstack([points, points[:3]]), "%.6f")
    return {"units": "mm"}


def as_matrix(path, ground):
    np.savetxt(path, ground.heights, "%.6f")
    return {"units": "mm", "spacing": 1e-3 * ground.step}


def as_matlab(path, ground):
    x, y, _ = ground.points().T.reshape(3, *ground.heights.shape)
    scipy.io.savemat(path, {"Z_um": 1e3 * ground.heights, "X_mm": x, "Y_mm": y})
    return {}


def as_surfer(path, ground):
    (ny, nx), (y, x) = ground.heights.shape, ground.corner
    ends = x + ground.step * (nx - 1), y + ground.step * (ny - 1)
    limits = [x, ends[0], y, ends[1], ground.heights.min(), ground.heights.max()]
    if path.stem == "c":
        grid = struct.pack("<2i8d", ny, nx, x, y, ground.step, ground.step, 0.0, 0.0, 0.0, 1e30)
        heights = ground.heights.astype("<f8").tobytes()
        sections = {b"DSRB": struct.pack("<i", 1), b"FLTI": bytes(5), b"GRID": grid}
        parts = (sections | {b"DATA": heights}).items()
        path.write_bytes(b"".join(name + struct.pack("<i", len(p)) + p for name, p in parts))
    elif path.stem == "b":
        head = b"DSBB" + struct.pack("<2h6d", nx, ny, *limits)
        path.write_bytes(head + ground.heights.astype("<f4").tobytes())
    else:
        numbers = " ".join(f"{value:.9f}" for value in ground.heights.ravel())
        path.write_text(f"DSAA {nx} {ny} {' '.join(map(repr, map(float, limits)))} {numbers}")
    return {"units": "mm"}


def as_three_files(path, ground):
    for name, matrix in zip(
        "xyz", ground.points().T.reshape(3, *ground.heights.shape), strict=True
    ):
        np.savetxt(path.parent / f"{name}.dat.txt", matrix, "%.6f")
    return {"units": "mm"}


def as_mesh(path, ground):
    trimesh = pytest.importorskip("trimesh")
    mesh = trimesh.Trimesh(ground.points(), triangles(ground.heights.shape), process=False)
    text = {"encoding": "ascii"} if path.name == "text.ply" else {}
    content = mesh.export(file_type=path.suffix[1:], **text)
    path.write_bytes(content.encode() if isinstance(content, str) else content)
    return {"units": "mm"}


def as_esri(path, ground):
    y, x = ground.corner
    write_esri(path, ground.heights, cellsize=ground.step, xllcorner=x, yllcorner=y)
    return {"units": "mm"}


def as_tiff(path, ground):
    tifffile = pytest.importorskip("tifffile")
    tifffile.imwrite(path, ground.heights)
    return {"units": "mm", "spacing": 1e-3 * ground.step}


FORMS = {
    "a.npy": as_npy,
    "a.npz": as_npz,
    "a.nc": as_netcdf,
    "a.csv": as_csv,
    "a.xyz": as_shuffled_text,
    "a.stl": as_mesh,
    "a.ply": as_mesh,
    "text.ply": as_mesh,
    "a.obj": as_mesh,
    "a.txt": as_matrix,
    "x.dat.txt,y.dat.txt,z.dat.txt": as_three_files,
    "a.mat": as_matlab,
    "a.grd": as_surfer,
    "b.grd": as_surfer,
    "c.grd": as_surfer,
    "a.asc": as_esri,
    "esri.txt": as_esri,
    "a.tif": as_tiff,
}


@st.composite
def grounds(draw):
    """The upper and the lower wall of a joint in one frame, z upwards."""
    shape = draw(st.integers(20, 28)), draw(st.integers(20, 28))
    step = draw(st.sampled_from([0.25, 0.3, 0.4, 1.0 / 3.0, 1.25]))
    corner = draw(st.tuples(*[st.sampled_from([0.0, 7.5, -30.0, 400.0])] * 2))
    seed = draw(st.integers(0, 1000))
    walls = jc.wall_pair(8.0, shape, 1e-3 * step, seed, correlation=0.9)
    upper, lower = (1e3 * wall for wall in walls)
    gap = draw(st.sampled_from([0.0, 2.0]))
    return Ground(gap - upper, step, corner), Ground(lower, step, corner)


def read_in(form: str, ground: Ground, folder: Path) -> Scan:
    given = FORMS[form](folder / form, ground)
    parts = [folder / part for part in form.split(",")]
    return read_scan(parts if len(parts) > 1 else parts[0], **given)


@RANDOM
@given(grounds(), st.sampled_from(sorted(FORMS)))
def test_all_forms_of_a_scan_are_one_scan(tmp_path, walls, form):
    for ground in walls:
        scan = read_in(form, ground, tmp_path)
        assert isinstance(scan, Scan)
        assert scan.spacing == pytest.approx((1e-3 * ground.step,) * 2, rel=1e-6)
        np.testing.assert_allclose(
            scan.heights,
            1e-3 * ground.heights,
            atol=1e-8 if form in ("a.obj", "text.ply") else 2e-9,
        )
        if (
            scan.origin is not None and FORMS[form] is not as_esri
        ):  # whose corner is that of its first cell
            assert scan.origin == pytest.approx([1e-3 * part for part in ground.corner], rel=1e-6)


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


DISTORTIONS = {
    cut_off: sorted(FORMS),
    one_lost_and_one_doubled: ["a.csv", "a.xyz", "a.obj", "text.ply", "a.txt", "a.asc", "esri.txt"],
}


@settings(RANDOM, max_examples=60)
@given(st.data(), grounds(), st.sampled_from(list(DISTORTIONS)))
def test_a_distorted_file_is_the_same_wall_where_it_has_heights_or_an_error(
    tmp_path, data, walls, distort
):
    ground, form = walls[1], data.draw(st.sampled_from(DISTORTIONS[distort]))
    given = FORMS[form](tmp_path / form, ground)
    parts = [tmp_path / part for part in form.split(",")]
    part = data.draw(st.sampled_from(parts))
    part.write_bytes(distort(data.draw, part.read_bytes()))
    try:
        scan = read_scan(parts if len(parts) > 1 else parts[0], **given)
    except jc.InputError:
        return
    assert isinstance(scan, Scan)
    assert scan.spacing == pytest.approx((1e-3 * ground.step,) * 2, rel=1e-6)
    place = np.zeros(2)
    if scan.origin is not None and FORMS[form] is not as_esri:
        place = (1e3 * np.array(scan.origin) - ground.corner) / ground.step
    y, x = np.nonzero(np.isfinite(scan.heights))
    rows, columns = np.round([y + place[0], x + place[1]]).astype(int)
    inside = (rows >= 0) & (columns >= 0)
    inside &= (rows < ground.heights.shape[0]) & (columns < ground.heights.shape[1])
    rows, columns, heights = rows[inside], columns[inside], scan.heights[y, x][inside]
    off = ~np.isclose(heights, 1e-3 * ground.heights[rows, columns], rtol=0.0, atol=1e-8)
    # a number that lost its end, or a point of a damaged line
    assert off.sum() + (~inside).sum() <= 1, (form, scan.remarks)


@pytest.fixture(scope="module")
def joint():
    upper, lower = (1e3 * wall for wall in jc.wall_pair(8.0, (24, 26), 3e-4, 3, correlation=0.9))
    corner = (7.5, 40.0)
    return Ground(2.0 - upper, 0.3, corner), Ground(lower, 0.3, corner)


def brought_together(scans):
    return registered(*scans, orientation="common_frame", cut_spikes=False)


@pytest.fixture(scope="module")
def expected(joint):
    return brought_together([Scan(1e-3 * wall.heights, (3e-4, 3e-4)) for wall in joint])


@pytest.mark.parametrize("forms", [["a.stl"] * 2, ["a.xyz", "a.csv"], ["a.nc", "a.stl"]])
def test_all_forms_of_two_scans_are_one_joint(forms, joint, expected, tmp_path):
    found = brought_together(
        [read_in(form, wall, tmp_path) for form, wall in zip(forms, joint, strict=True)]
    )
    assert found.spacing == expected.spacing
    for one, other in ((expected.upper, found.upper), (expected.lower, found.lower)):
        np.testing.assert_allclose(other, one, atol=2e-9)


def test_a_lost_line_changes_a_joint_at_its_place_only(joint, expected, tmp_path):
    scans, places = [], ((5, 7), (20, 3))
    for ground, (y, x) in zip(joint, places, strict=True):
        points = np.delete(ground.points(), y * 26 + x, axis=0)
        np.savetxt(tmp_path / "a.xyz", points, "%.6f", header="x_mm y_mm z_mm")
        scans.append(read_scan(tmp_path / "a.xyz"))
    found = brought_together(scans)
    for one, other, place in zip(
        (expected.upper, expected.lower), (found.upper, found.lower), places, strict=True
    ):
        difference = np.abs(other - one)
        largest = difference[place]
        difference[place] = 0.0
        assert difference.max() <= 0.02 * largest  # of the plane, to which one height counts


@pytest.mark.parametrize(
    ("version", "missing"), [(1, [[0, 1, 1], [0, 0, 0]]), (2, [[0, 0, 1]] * 2)]
)
def test_heights_that_a_surfer_7_grid_leaves_out_are_missing(version, missing, tmp_path):
    grid = struct.pack("<2i8d", 3, 3, 0.0, 0.0, 0.3, 0.3, 0.0, 0.0, 0.0, 7.0)
    heights = np.array([[1.0, 8.0, 7.0], [1.0, 2.0, 3.0 if version == 1 else 7.0], [3.0, 1.0, 2.0]])
    parts = {b"DSRB": struct.pack("<i", version), b"GRID": grid, b"DATA": heights.tobytes()}
    content = b"".join(name + struct.pack("<i", len(p)) + p for name, p in parts.items())
    (tmp_path / "a.grd").write_bytes(content)
    scan = read_scan(tmp_path / "a.grd", units="mm")
    np.testing.assert_array_equal(np.isnan(scan.heights[:2]), np.array(missing, dtype=bool))


@pytest.mark.parametrize(
    ("names", "shown"), [("xz", "must be one file, or three"), ("xyz", "24 x 26, 3 x 4, 24 x 26")]
)
def test_two_matrices_and_three_of_different_shapes_are_refused(names, shown, joint, tmp_path):
    given = as_three_files(tmp_path / "a", joint[0])
    np.savetxt(tmp_path / "y.dat.txt", np.ones((3, 4)))
    with pytest.raises(jc.InputError, match=shown):
        read_scan(",".join(str(tmp_path / f"{name}.dat.txt") for name in names), **given)


def test_an_aperture_map_on_a_flat_wall_is_a_rough_wall_under_a_flat_one(joint):
    rough = joint[1].heights
    tilted = rough + 0.02 * np.indices(rough.shape)[1]
    lower, aperture = (Scan(1e-3 * part, (3e-4, 3e-4)) for part in (tilted, rough.max() - rough))
    under = registered("flat", lower, cut_spikes=False)
    mapped = registered(aperture, "flat", orientation="common_frame", cut_spikes=False)
    turned = registered(lower, "flat", orientation="towards", cut_spikes=False)
    for pair in (mapped, turned):
        np.testing.assert_allclose(pair.aperture, under.aperture, atol=1e-12)
    assert not under.upper.any()
    assert not mapped.lower.any()
    assert not under.warnings
    for scans, orientation in (((lower, "flat"), None), (("flat", "flat"), None)):
        with pytest.raises(jc.InputError, match="flat"):
            registered(*scans, orientation=orientation)
    with pytest.raises(jc.InputError, match="must be left out"):
        registered("flat", lower, orientation="towards")


def test_the_report_on_a_flat_wall_does_not_describe_two_scans(joint):
    heights = 1e-3 * joint[1].heights
    y, x = np.indices(heights.shape)
    heights[abs(y - x) > 8] = np.nan  # most of what is left is outside of the largest rectangle
    pair = registered("flat", Scan(heights, (3e-4, 3e-4)), cut_spikes=False)
    assert pair.overlap < 0.5
    assert not pair.warnings
    lines = " ".join(pair.report)
    assert f"{100 * pair.overlap:.0f} % of it" in lines
    assert "overlap" not in lines
    assert "each other" not in lines


def test_the_figure_of_a_flat_wall_has_no_empty_panel(joint):
    lower = Scan(1e-3 * joint[1].heights, (3e-4, 3e-4))
    upper = Scan(-1e-3 * joint[0].heights, (3e-4, 3e-4))
    for walls, number in ((("flat", lower), 4), ((upper, lower), 6)):
        pair = registered(*walls, cut_spikes=False, unusual_values=True)
        axes = pair_figure(pair, "a joint").axes
        panels = [panel for panel in axes if panel.get_label() != "<colorbar>"]
        assert len(panels) == number
        assert all(panel.has_data() and panel.axison for panel in panels)


def test_a_joint_with_a_flat_wall_closes(joint):
    lower = Scan(1e-3 * joint[1].heights, (3e-4, 3e-4))
    closed = jc.close("flat", lower, rock=DOLERITE, max_normal_stress=1e6, single=True)
    assert closed.history.status == 0
    assert (closed.history.max_closure > 0.0).all()


def test_close_chooses_an_array_of_a_file_by_variable(joint, tmp_path):
    path, other = tmp_path / "a.npz", np.zeros((4, 4))
    np.savez(path, Z_mm=joint[1].heights, other_mm=other, spacing_mm=joint[1].step)
    options = {"rock": DOLERITE, "max_normal_stress": 1e6, "single": True}
    with pytest.raises(
        jc.InputError, match=r"variable \(--variable on the command line\) must name"
    ):
        jc.close(path, "flat", orientation="towards", **options)
    chosen = jc.close(path, "flat", orientation="towards", variable="Z_mm", **options)
    scan = Scan(1e-3 * joint[1].heights, (1e-3 * joint[1].step,) * 2)
    stated = jc.close(scan, "flat", orientation="towards", **options)
    np.testing.assert_array_equal(chosen.history.max_closure, stated.history.max_closure)


def walls_of_files(upper, lower, spacing, **_):
    """A study's walls that lie as they are given."""
    about = Walls("top", "bottom", "mm", None, None, "refuse", 0.05, ())
    scans = {"upper": Scan(upper, (spacing, spacing)), "lower": Scan(lower, (spacing, spacing))}
    return prepared_walls(scans, about, spacing, "yu_vayssade_linear_0.25mm")


def close_scans(upper, lower, spacing, rock):
    scans = [Scan(wall, (spacing, spacing)) for wall in (-upper, lower)]
    options = {"orientation": "common_frame", "single": True}
    return jc.close(*scans, rock=rock, max_normal_stress=1e6, **options)


DOORS = {
    "simulate": lambda *pair, **s: jc.simulate(*pair, max_normal_stress=1e6, **s),
    "equilibrium": lambda *pair, **s: jc.equilibrium(*pair, closure=1e-6, **s),
    "ensemble": lambda *pair, **s: jc.simulate_ensemble([pair], max_normal_stress=1e6, **s),
    "effects": lambda *pair, **s: choose_effects([pair], max_normal_stress=1e6, **s),
    "close": close_scans,
    "study": walls_of_files,
}


@pytest.mark.parametrize("door", sorted(DOORS))
@settings(RANDOM, max_examples=4)
@given(
    st.integers(0, 1000),
    st.sampled_from(["heights", "spacing"]),
    st.sampled_from([1e3, 1e-3]),
)
def test_a_unit_a_thousand_times_off_is_refused_or_warned_of_at_every_door(
    door, seed, what, factor
):
    upper, lower = jc.wall_pair(8.0, (32, 32), SPACING, seed, correlation=0.9)
    spacing = SPACING
    if what == "heights":
        upper, lower = factor * upper, factor * lower
    else:
        spacing *= factor
    with warnings.catch_warnings():
        warnings.simplefilter("error", UserWarning)  # so that nothing is computed
        with pytest.raises((jc.InputError, UserWarning)):
            DOORS[door](upper, lower, spacing=spacing, rock=DOLERITE)


@pytest.mark.parametrize("form", ["npz", "mat"])
def test_a_mask_beside_heights_is_not_left_unread(form, tmp_path):
    arrays = {"Z_mm": np.random.default_rng(1).random((12, 14)), "spacing_mm": 0.25}
    arrays["mask"] = arrays["Z_mm"] > 0.5
    path = tmp_path / f"scan.{form}"
    if form == "npz":
        np.savez(path, **arrays)
    else:
        scipy.io.savemat(path, arrays)
    with pytest.raises(jc.InputError, match="mask"):
        read_scan(path)

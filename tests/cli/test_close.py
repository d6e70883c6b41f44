"""`jointclosure close` and `jc.close`: two scans in, curves out; refusals in one line."""

import functools
import json

import numpy as np
import pandas as pd
import pytest

import jointclosure as jc
from jointclosure.cli import main as cli
from jointclosure.cli.exports import FIGURES
from jointclosure.cli.results import summary
from jointclosure.engine import scanned_joint
from jointclosure.engine.budget import ALL, MEASURED, QUANTITIES, TOGETHER, Budget
from jointclosure.inputs.remarks import cautions
from jointclosure.joint.rocks import named_rock
from jointclosure.storage.netcdf import read_netcdf
from jointclosure.walls.registration import registered
from tests.joints import SPACING, TWO_WALLS

SHAPE = (64, 72)
LOAD = {"max_normal_stress": 2e6, "seating_stress": 0.2e6}
RESOLVED = {"numerics": scanned_joint.RESOLVED}
WORDS = ["--units", "mm", "--stress", 2, "--seating", 0.2]


def write_points(path, heights):
    """A scan as instruments write it: a head, separators at the ends of lines, millimetres."""
    y, x = np.indices(heights.shape) * 1e3 * SPACING
    points = np.column_stack([x.ravel(), y.ravel(), 1e3 * heights.ravel()])
    lines = [",".join(f"{value:.6f}" for value in point) + "," for point in points]
    path.write_text("\n".join(["x,y,z", "x,y,z", *lines]))


@pytest.fixture(scope="module")
def scans(tmp_path_factory):
    """Both walls of a joint in one frame, z upwards, and a wall of another joint."""
    folder = tmp_path_factory.mktemp("scans")
    upper, lower = jc.wall_pair(9.0, SHAPE, SPACING, seed=4, correlation=0.9, roll_off=None)
    write_points(folder / "top.xyz", 0.6e-3 - upper)
    write_points(folder / "bottom.xyz", lower)
    write_points(folder / "other.xyz", jc.wall_pair(9.0, SHAPE, SPACING, seed=5)[0])
    return folder


def shown(capsys, *words):
    code = cli.main(["close", *map(str, words)])
    return code, *capsys.readouterr()


def test_two_scans_are_closed_as_their_registered_walls_are(scans, tmp_path, capsys):
    files = scans / "top.xyz", scans / "bottom.xyz"
    words = [*WORDS, "--single", "--rock", "granite", "--output", tmp_path / "j"]
    code, out, err = shown(capsys, *files, *words)
    assert (code, err) == (0, "")
    assert "orientation of the upper wall, found: common_frame" in out
    assert "Granite (Young's modulus 73 GPa, Poisson's ratio 0.25, compressive strength" in out
    assert "72 x 64 cells of 0.25 mm: 2 MPa, 2 cycles" in out
    pair = registered(*(jc.read_scan(file, units="mm") for file in files))
    rock = jc.Rock(73e9, 0.25, 173e6)
    alone = jc.simulate(pair.upper, pair.lower, spacing=pair.spacing, rock=rock, **LOAD, **RESOLVED)
    library = jc.close(*files, units="mm", rock="granite", single=True, **LOAD)
    written = read_netcdf(tmp_path / "j/joint.nc")
    for name in alone.data_vars:
        np.testing.assert_array_equal(written[name], alone[name])
        np.testing.assert_array_equal(library.history[name], alone[name])
    curves = pd.read_csv(tmp_path / "j/curves.csv")
    first = curves[(curves.cycle == 1) & (curves.branch == "loading")]
    assert first.closure_gross_mm.iloc[-1] == pytest.approx(1e3 * float(alone.max_closure[0]))
    seated = float(alone.max_closure_seated[0])
    assert first.closure_gross_since_seating_mm.iloc[-1] == pytest.approx(1e3 * seated)
    record = json.loads((tmp_path / "j/joint.json").read_text())
    assert record["found"] == pair.report
    assert record["warnings"] == cautions(pair.report)
    assert record["mismatch_wavelength_mm"]["wavelength"] == 1e3 * library.pair.mismatch.wavelength
    assert sum("the walls are mated at " in line for line in pair.report) == 1
    assert set(record["sha256"]) == {"upper", "lower"}
    settings = json.loads(record["provenance"]["settings"])
    assert settings["upper"] == str(files[0])
    assert settings["rock"] == named_rock("granite")._asdict()
    assert record["provenance"]["source_digest"]
    for picture in ("walls.png", "closure.png"):
        assert (tmp_path / "j" / picture).stat().st_size > 20000
    assert record["rock"]["upper"] == record["rock"]["lower"] == {
        "youngs_modulus_GPa": 73.0, "poisson_ratio": 0.25, "compressive_strength_MPa": 173.0
    }  # fmt: skip
    line, cycles = repr(library), pd.read_csv(tmp_path / "j/cycles.csv")
    assert line.startswith("<ClosedJoint: granite (Young's modulus 73 GPa, Poisson's ratio 0.25, ")
    assert "72 x 64 cells of 0.25 mm (18 x 16 mm)" in line
    net = [f"{value:.4g}" for value in cycles.max_closure_seated_net_mm]
    assert f"closes {', '.join(net)} mm net" in line
    assert str(library) == line
    assert "\n" not in line
    ends = {
        "best": 0.18,
        "median": 0.18,
        "low": 0.13,
        "high": 0.24,
        "spacing": 0.75,
        "breakage": 0.25,
    }
    ends["together"] = 0.0
    index = pd.MultiIndex.from_product([[1, 2], QUANTITIES], names=["cycle", "quantity"])
    ranges = pd.DataFrame([ends] * len(index), index)
    joint = {"source": [""], "value": [""], "cycle": [1]}
    results = pd.DataFrame(joint | {name: [0.18] for name in QUANTITIES})
    printed = str(library._replace(budget=Budget(results, ranges, ())))
    assert "0.18 (0.13 to 0.24)" in printed.splitlines()[0]
    assert "the range is due to grid spacing 75 %, breakage rule 25 %" in printed
    assert printed.endswith(MEASURED)


def test_flow_and_snapshots_of_scanned_walls_are_there_where_asked_for(scans, tmp_path, capsys):
    files = scans / "top.xyz", scans / "bottom.xyz"
    words = [*files, *WORDS, "--single", "--rock", "granite", "--flow", "--output", tmp_path / "j"]
    words += ["--snapshots", "1,2"]
    code, out, err = shown(capsys, *words)
    assert (code, err) == (0, "")
    assert "hydraulic along x" in out
    assert (read_netcdf(tmp_path / "j/joint.nc").hydraulic_aperture > 0.0).all()
    assert set(read_netcdf(tmp_path / "j/joint.nc").snapshot_stress.values) == {1e6, 2e6}
    assert (tmp_path / "j/snapshots.png").stat().st_size > 20000
    assert "hydraulic_aperture_x_mm" in pd.read_csv(tmp_path / "j/curves.csv")


def test_walls_lie_as_is_stated_and_are_moved_if_asked_to(scans):
    files = scans / "top.xyz", scans / "bottom.xyz"
    about = {"units": "mm", "rock": "granite", **LOAD, "cycles": 1, "single": True}
    with pytest.raises(jc.InputError, match="orientation = 'rotated': common_frame fits clearly"):
        jc.close(*files, **about, orientation="rotated")
    fits = jc.close(*files, **about)
    wrong = jc.close(*files, **about, orientation="rotated", unusual_values=True)
    warned = "\n".join(cautions(wrong.pair.report))
    assert "Warning: the stated orientation rotated" in warned
    assert float(wrong.history.max_closure[0]) > 1.3 * float(fits.history.max_closure[0])
    about["unusual_values"] = True
    moved = jc.close(*files, **about, shift="mated", orientation="rotated").pair
    assert moved.shift == moved.mating_shift != (0.0, 0.0)


def test_the_range_of_a_joint_is_printed_stored_and_shown(scans, tmp_path, capsys):
    files = scans / "top.xyz", scans / "bottom.xyz"
    stated = ["--range", "compressive_strength_MPa", 100, 250]
    words = [*files, *WORDS, "--cycles", 1, "--rock", "granite", *stated, "--output", tmp_path]
    code, out, err = shown(capsys, *words)
    assert (code, err) == (0, "")
    record = json.loads((tmp_path / "joint.json").read_text())
    closure = record["range"][0]
    assert closure["quantity"] == "max_closure_seated_net_mm"
    assert closure["best"] == record["per_cycle"]["max_closure_seated_net_mm"][0]
    assert closure["low"] <= closure["median"] <= closure["high"]
    assert closure["text"] in out
    assert sum(closure["shares"].values()) == pytest.approx(1.0)
    assert {"spacing", "breakage", "alignment", "compressive_strength"} <= set(closure["shares"])
    sources = set(pd.read_csv(tmp_path / "range.csv").source.dropna())
    assert {*sources, TOGETHER} == {*closure["shares"], ALL}
    assert (tmp_path / "range.png").stat().st_size > 20000
    assert cli.main(["report", str(tmp_path)]) == 0
    page = (tmp_path / "report.html").read_text()
    assert f"closes {closure['text']} mm in its first cycle" in page
    twice = ["compressive_strength_MPa", 1, 2, *stated]
    for ends in (["strength", 1, 2], ["compressive_strength_MPa", "a", 2], twice):
        code, _, err = shown(capsys, *files, *WORDS, "--rock", "granite", "--range", *ends)
        assert (code, err.count("\n")) == (2, 1)
        assert f"--range {ends[0]}" in err


def test_a_range_that_is_not_allowed_is_refused_before_the_joint_is_closed(scans, monkeypatch):
    monkeypatch.setattr(scanned_joint, "close_walls", lambda *given: pytest.fail("closed"))
    files = scans / "top.xyz", scans / "bottom.xyz"
    for ranges in ({"strength": (1e8, 2e8)}, {"spacing": (1e-4, 1e-3)}):
        with pytest.raises(jc.InputError, match=rf"ranges: '?{next(iter(ranges))}'?"):
            jc.close(*files, units="mm", rock="granite", ranges=ranges, **LOAD)


@pytest.mark.parametrize(
    ("files", "words", "message"),
    [
        (("top.xyz", "bottom.xyz"), ["--rock", "granite"], "does not state the units"),
        (
            ("bottom.xyz", "top.xyz"),
            [*WORDS, "--rock", "granite"],
            "top.xyz: upper and lower: the upper wall lies below the lower one in",
        ),
        (
            ("top.xyz", "no.xyz"),
            [*WORDS, "--rock", "granite"],
            "no.xyz: file not found",
        ),
        (
            ("top.xyz", "bottom.xyz"),
            [*WORDS, "--rock", "granit"],
            "--rock granit: must be one of dolerite, siltstone, limestone, slate, granite",
        ),
        (
            ("top.xyz", "bottom.xyz"),
            WORDS,
            "without --rock (such as --rock granite): --youngs-modulus, --poisson-ratio",
        ),
        (
            ("", ""),
            ["--rock", "granite"],
            "both walls are flat; one must be a scan",
        ),
        (
            ("top.xyz", "bottom.xyz"),
            [*WORDS, "--rock", "granite", "--output", "no/where"],
            "no/where: folder no not found",
        ),
    ],
)
def test_what_is_wrong_is_one_line_and_nothing_is_closed(
    files, words, message, scans, capsys, monkeypatch, tmp_path
):
    monkeypatch.setattr("jointclosure.engine.scanned_joint.close_walls", None)
    output = [] if "--output" in words else ["--output", tmp_path / "j"]
    code, _, err = shown(
        capsys, *(scans / file if file else "flat" for file in files), *words, *output
    )
    assert code == 2
    assert err.count("\n") == 1
    assert message.format(scans) in err


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        (["--largest-radius", "20", "--tolerance", "0.05"], 0.05),
        (["--largest-radius", "20", "--force-tolerance", "1e-6"], 0.01),
        (["--largest-radius", "20", "--breakage", "fixed_step"], None),
    ],
)
def test_settings_add_up_and_only_the_rule_of_breakage_replaces_resolved_breakage(
    words, expected, tmp_path, monkeypatch
):
    closed = {}

    @functools.wraps(jc.close)
    def stopped(*walls, **given):
        closed.update(given)
        raise jc.InputError("enough")

    monkeypatch.setattr("jointclosure.cli.close.close", stopped)
    command = ["close", "a.txt", "b.txt", "--rock", "Granite", "--output", tmp_path / "j", *words]
    assert cli.main([str(word) for word in command]) == 2
    assert closed["choices"] == jc.Choices(largest_radius=0.02)
    usual = scanned_joint.RESOLVED if expected else jc.Numerics()
    for name in ("breakage", "displacement_step", "later_breakage_step"):
        assert getattr(closed["numerics"], name) == getattr(usual, name)
    assert expected in (None, closed["numerics"].tolerance)


def test_a_wall_that_is_an_array_is_refused_with_what_closes_it(small_joint):
    with pytest.raises(jc.InputError, match=r"of type ndarray: must be a file.*simulate"):
        jc.close(*small_joint, rock="granite", max_normal_stress=1e6)
    with pytest.raises(jc.InputError, match="rock = 'marble': must be a Rock or one of dolerite"):
        jc.close("a.xyz", "b.xyz", rock="marble", max_normal_stress=1e6)


def contents(folder):
    return {path.name: path.read_bytes() for path in folder.iterdir()}


def test_a_folder_written_twice_equals_one_written_once(scans, tmp_path, capsys):
    """Of another joint nothing stays, and what someone else put there is left alone."""
    twice, once = tmp_path / "twice", tmp_path / "once"
    files = scans / "top.xyz", scans / "bottom.xyz"
    words = [*files, *WORDS, "--single", "--cycles", 1, "--rock", "granite", "--output"]
    first = [*words, twice, "--snapshots", "1,2"]
    assert shown(capsys, *first)[::2] == (0, "")
    (twice / "notes.txt").write_text("mine")
    assert cli.main(["report", str(twice)]) == 0
    written = {"snapshots.png", "geos.xml", "geos_gap.csv", "geos_aperture.csv", "report.html"}
    assert written <= set(contents(twice))
    (_, out, _), _ = (
        # from first touch on GEOS has no form
        shown(capsys, *words, folder, "--seating", 0)
        for folder in (twice, once)
    )
    listed = out.splitlines()[-1].partition(": ")[2].split(", ")
    assert (twice / "notes.txt").read_text() == "mine"
    (twice / "notes.txt").unlink()
    assert contents(twice) == contents(once)
    assert sorted([*listed, "written.json"]) == sorted(contents(once))
    assert not written & set(contents(once))


@pytest.mark.slow
def test_both_walls_of_a_published_fracture_are_closed_with_defaults_for_granite(tmp_path, capsys):
    if not TWO_WALLS.is_dir():
        pytest.skip("the two walls are not here")
    files = TWO_WALLS / "side_b_top.txt", TWO_WALLS / "side_a_bottom.txt"
    words = ["--units", "mm", "--rock", "granite", "--output", tmp_path / "j"]
    code, out, err = shown(capsys, *files, *words)
    assert (code, err) == (0, "")
    record = json.loads((tmp_path / "j/joint.json").read_text())
    assert record["status"] == "success"
    assert record["orientation"] == "common_frame"
    assert record["cells_y_x"] == [188, 188]
    assert "the first contact stands out far" in out
    per_cycle = record["per_cycle"]
    first, second = per_cycle["max_closure_seated_net_mm"]
    assert 0.0 < second < first < per_cycle["max_closure_mm"][0]
    values_stated = pd.read_csv(tmp_path / "j/cycles.csv")  # one definition of what stays
    for name in values_stated.columns.drop("cycle"):
        assert per_cycle[name] == pytest.approx(values_stated[name].tolist(), rel=1e-6)
    words = (tmp_path / "j/cycles.csv").read_text().splitlines()[1].split(",")
    assert max(len(word.replace(".", "").lstrip("0")) for word in words) <= FIGURES


def test_a_joint_without_void_on_average_is_warned_of(small_joint):
    closed = jc.simulate(
        *small_joint, spacing=0.25e-3, rock=named_rock("granite"), max_normal_stress=1e6
    )
    assert "warning" not in summary(closed)
    closed["mean_aperture"] = closed.mean_aperture - 2.0 * closed.mean_aperture.max()
    assert summary(closed).count("warning: the mean aperture is -") == closed.cycle.max()

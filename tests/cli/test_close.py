"""A joint of two scans, closed by the command or in Python: its curves, files and page."""

import functools
import json
import re
import shutil
from unittest.mock import Mock

import numpy as np
import pandas as pd
import pytest
from PIL import Image

import jointclosure as jc
from jointclosure.cli import main as cli
from jointclosure.cli import report
from jointclosure.cli.command_results import summary, with_bands
from jointclosure.ensembles.quantities import CURVES
from jointclosure.exports.loading import loading_remark
from jointclosure.inputs.remarks import cautions
from jointclosure.joint import conditions
from jointclosure.joint.result_tables import stress_table
from jointclosure.joint.rocks import named_rock
from jointclosure.storage.netcdf import read_netcdf
from jointclosure.uncertainty import scanned_joint
from jointclosure.uncertainty.budget import AT_END
from jointclosure.uncertainty.ranged_results import RANGED_RESULTS
from jointclosure.uncertainty.sources import ALL, OTHER_RULE
from jointclosure.walls.registration import registered
from tests.cli.conftest import leave_undrawn
from tests.joints import TWO_WALLS

LOAD = {"max_normal_stress": 2e6, "seating_stress": 0.2e6}
RESOLVED = {"numerics": conditions.RESOLVED}
WORDS = ["--units", "mm", "--stress", 2, "--seating", 0.2, "--rock", "granite"]
COARSE = ["--spacing", 0.5, "--tolerance", 0.1]
"""Of a joint whose numbers are compared with those of no other."""


@pytest.fixture(scope="module")
def scans(inputs):
    return inputs / "top.xyz", inputs / "bottom.xyz"


@pytest.fixture(scope="module")
def joint(scans):
    """The joint of both scans, closed by the library."""
    return jc.close(*scans, units="mm", rock="granite", spacing=1e-3, single=True, **LOAD)


def contents(folder):
    return {path.name: path.read_bytes() for path in folder.iterdir()}


def test_two_scans_are_closed_as_their_registered_walls_are(
    scans, joint, tmp_path, command, undrawn
):
    folder = tmp_path / "j"
    words = [*WORDS, "--spacing", 1, "--single"]
    code, _, err = command("close", *scans, *words, "--output", folder)
    assert (code, err) == (0, "")
    pair = registered(*(jc.read_scan(file, units="mm") for file in scans), 1e-3)
    rock = jc.Rock(73e9, 0.25, 173e6)
    alone = jc.simulate(pair.upper, pair.lower, spacing=pair.spacing, rock=rock, **LOAD, **RESOLVED)
    written = read_netcdf(folder / "joint.nc")
    for name in alone.data_vars:
        np.testing.assert_array_equal(written[name], alone[name])
        np.testing.assert_array_equal(joint.history[name], alone[name])
    curves = pd.read_csv(folder / "curves.csv")
    first = curves[(curves.cycle == 1) & (curves.branch == "loading")].iloc[-1]
    assert first.closure_gross_mm == pytest.approx(1e3 * float(alone.max_closure[0]))
    seated = 1e3 * float(alone.max_closure_seated[0])
    assert first.closure_gross_since_seating_mm == pytest.approx(seated)
    record = json.loads((folder / "joint.json").read_text())
    assert record["found"] == joint.pair.remarks
    assert record["found"][: len(pair.remarks)] == pair.remarks
    assert record["warnings"] == cautions([*pair.remarks, loading_remark(joint.history, 1)])
    assert record["mismatch_wavelength_mm"]["wavelength"] == 1e3 * joint.pair.mismatch.wavelength
    assert set(record["sha256"]) == {"upper", "lower"}
    settings = json.loads(record["provenance"]["settings"])
    assert settings["upper"] == str(scans[0])
    assert settings["rock"] == named_rock("granite")._asdict()
    assert record["provenance"]["source_digest"]
    rock = {"youngs_modulus_GPa": 73.0, "poisson_ratio": 0.25, "compressive_strength_MPa": 173.0}
    assert record["rock"]["upper"] == record["rock"]["lower"] == rock
    bandis = pd.read_csv(folder / "answer.csv").groupby("cycle").barton_bandis_mm.max()
    for cycle, law in enumerate(record["barton_bandis"]["results"].values(), start=1):
        assert bandis[cycle] == pytest.approx(law["max_closure_seated_net_mm"], rel=1e-6)
    assert record["table"]["cycle 2"]["net residual closure at seating (mm)"] == "not modelled"
    cycles = pd.read_csv(folder / "cycles.csv")
    for name in cycles.columns.drop("cycle"):
        assert record["per_cycle"][name] == pytest.approx(cycles[name].tolist(), rel=1e-6)


def test_stiffness_at_named_stresses_is_that_of_the_curves(scans, tmp_path, command, undrawn):
    words = [*WORDS, "--spacing", 1, "--single", "--at", "1.3,0.7", "--output", tmp_path / "j"]
    code, out, err = command("close", *scans, *words)
    assert (code, err) == (0, "")
    curves = pd.read_csv(tmp_path / "j/answer.csv")
    loading = curves[curves.branch == "loading"].set_index(["cycle", "normal_stress_MPa"])
    record = json.loads((tmp_path / "j/joint.json").read_text())
    rows = [(row["cycle"], row["normal stress (MPa)"]) for row in record["at"]]
    assert rows == [(1, 0.7), (1, 1.3), (2, 0.7), (2, 1.3)]
    for row, place in zip(record["at"], rows, strict=True):
        text = row["net tangent stiffness kn (MPa/mm)"]
        stored = loading.loc[place, "normal_stiffness_net_MPa_per_mm"]
        assert float(text) == pytest.approx(stored, rel=1e-3)
        assert text in out
    assert command("report", tmp_path / "j")[0] == 0
    assert "stresses that were named" in (tmp_path / "j/report.html").read_text()


@pytest.mark.parametrize("stresses", ["2.5", "1,0", "-1", "nan", "0.3"])
@pytest.mark.parametrize("name", ["close", "simulate"])
def test_a_stress_that_no_loading_reaches_is_refused_before_any_computing(
    scans, name, stresses, command, monkeypatch
):
    for module in (
        "cli.simulate.simulate_as_checked",
        "uncertainty.scanned_joint.registered_walls",
    ):
        monkeypatch.setattr(f"jointclosure.{module}", Mock(side_effect=AssertionError))
    files = scans if name == "close" else ["--jrc", 8]
    own = ["--units", "mm"] if name == "close" else []
    words = [*own, "--stress", 2, "--rock", "granite", f"--at={stresses}"]
    code, _, err = command(name, *files, *words)
    assert code == 2
    value = stresses.rpartition(",")[2]
    allowed = "from the seating stress, 0.5 MPa, to the maximum normal stress, 2 MPa"
    assert f"at (--at): {value} MPa: must be {allowed}" in err


@pytest.mark.parametrize(("seating", "allowed"), [(0.3, True), (0, True), (0.4, False)])
def test_a_named_stress_is_allowed_from_the_stated_seating_stress_on(
    seating, allowed, command, monkeypatch
):
    reached = Mock(side_effect=jc.InputError("simulated"))
    monkeypatch.setattr("jointclosure.cli.simulate.simulate_as_checked", reached)
    words = ["--rock", "slate", "--cells", 8, "--jrc", 8, "--stress", 2, "--at", 0.3]
    command("simulate", *words, "--seating", seating)
    assert reached.called == allowed


def test_an_interrupt_within_a_kernel_is_one(scans, command, monkeypatch):
    caused = SystemError("a result with an exception set")
    caused.__cause__ = KeyboardInterrupt()
    for error, printed in ((KeyboardInterrupt(), True), (caused, True), (SystemError(), False)):
        stopped = functools.wraps(jc.close)(Mock(side_effect=error))
        monkeypatch.setattr("jointclosure.cli.close.close", stopped)
        if printed:
            assert command("close", *scans, *WORDS)[::2] == (130, "jointclosure: interrupted\n")
            continue
        with pytest.raises(SystemError):
            command("close", *scans, *WORDS)


def test_an_interrupted_range_leaves_the_joint_itself(
    scans, tmp_path, command, undrawn, monkeypatch
):
    monkeypatch.setattr(scanned_joint, "uncertainty_budget", Mock(side_effect=KeyboardInterrupt))
    folder = tmp_path / "j"
    code, out, _ = command("close", *scans, *WORDS, *COARSE, "--cycles", 1, "--output", folder)
    assert code == 0
    assert "the range was stopped" in out
    assert json.loads((folder / "joint.json").read_text())["warnings"]
    assert (folder / "joint.nc").exists()
    assert not (folder / "range.csv").exists()


@pytest.fixture(scope="module")
def ranged(scans, tmp_path_factory, shared_command):
    """The folder that a joint with its range is written to, what is printed, and the record."""
    folder = tmp_path_factory.mktemp("ranged")
    stated = ["--range", "compressive_strength_MPa", 100, 250]
    words = [*scans, *WORDS, *COARSE, "--cycles", 1, *stated, "--output", folder]
    code, out, err = shared_command("close", *words)
    assert (code, err) == (0, "")
    return folder, out, json.loads((folder / "joint.json").read_text())


def test_the_range_of_a_quantity_holds_its_best_value(ranged):
    _, _, record = ranged
    closure = record["range"][0]
    assert closure["quantity"] == "max_closure_seated_net_mm"
    assert closure["best"] == record["per_cycle"]["max_closure_seated_net_mm"][0]
    for row in record["range"]:
        assert row["low_with_choices"] <= row["low"] <= row["best"]
        assert row["best"] <= row["high"] <= row["high_with_choices"]
    (kni,) = (row for row in record["range"] if row["quantity"] == "kni_net_MPa_per_mm")
    assert 0.0 < kni["low"] < kni["high"]


def test_the_range_of_a_joint_is_printed(ranged):
    _, out, record = ranged
    assert record["range"][0]["text"] in out


def test_the_screen_has_forty_lines_at_most_and_every_warning(ranged):
    """Without bars of progress; results of one cycle or of two take as many lines."""
    _, out, record = ranged
    lines = [line for line in out.splitlines() if not line.startswith("range: ")]
    assert len(lines) - len(record["warnings"]) <= 40
    assert all(f"- {warning}" in lines for warning in record["warnings"])
    assert set(record["with_other_choices"]["cycle 1"]) == set(record["table"]["cycle 1"])
    assert len(record["found"]) > 5
    assert len(record["remarks"]) > 5


def test_the_screen_says_of_which_cycle_exports_are_and_their_error_with_choices(ranged):
    """As the files do, of which each has its own error."""
    folder, out, record = ranged
    (geos,) = re.findall(r"geos_barton_bandis.xml, of cycle 1: .* is off by up to (.*); with other "
                         r"choices of the model it is off by up to (.*)\n", out)  # fmt: skip
    file = (folder / "geos_barton_bandis.xml").read_text()
    of_files = re.findall(r"off by up to (\S+) um, (\S+) %", file)
    assert " um, ".join(of_files[0]) + " %" == geos[0]
    with_choices = max(float(um) for um, _ in of_files[-2:])
    assert geos[1].startswith(f"{with_choices:g} um")
    assert "PorePy, UDEC, 3DEC, of cycle 1: the stiffness" in out
    assert "with other choices of the model by up to" in out
    assert all(f"- {line}" in out for line in record["exports"][1:])


def test_values_without_a_range_say_why(ranged):
    _, out, _ = ranged
    assert "Barton-Bandis values have no range, because JRC and JCS are taken as exact" in out
    assert "taken as exact, and not varied in the range: Young's modulus" in out


def test_a_result_at_an_end_of_its_range_says_why(ranged):
    _, out, record = ranged
    rows = [row for row in record["range"] if row["high"] > row["low"]]
    at_end = [
        row["quantity"]
        for row in rows
        if min(row["best"] - row["low"], row["high"] - row["best"])
        <= AT_END * (row["high"] - row["low"])
    ]
    (line,) = [line for line in out.split("\n") if "range on one side" in line] or [""]
    assert bool(at_end) == bool(line)
    for row in rows:
        name = RANGED_RESULTS[row["quantity"]].partition(" (")[0]
        assert (f"{name}, cycle 1" in line) == (row["quantity"] in at_end)


def test_each_source_of_the_range_has_its_share(ranged):
    folder, _, record = ranged
    shares = record["range"][0]["shares"]
    assert sum(shares.values()) >= 1.0 - 1e-9  # interactions count for each source
    assert {"spacing", "registration", "order", "compressive_strength"} <= set(shares)
    sources = set(pd.read_csv(folder / "range.csv").source.dropna())
    assert sources == {*shares, ALL, OTHER_RULE}


def test_the_range_is_drawn(ranged):
    assert (ranged[0] / "range.png").stat().st_size > 20000


def test_curves_lie_between_the_ends_of_their_range(ranged):
    curves = pd.read_csv(ranged[0] / "answer.csv")
    for name in ("closure_net_since_seating_mm", "normal_stiffness_net_MPa_per_mm"):
        for column in (f"{name}_low", name, f"{name}_high"):
            along = curves[curves.branch == "loading"][column]
            assert (along.diff().dropna() >= -1e-9).all()
        middle = curves[name]
        assert (curves[f"{name}_low"] <= middle * (1.0 + 1e-6)).all()
        assert (middle <= curves[f"{name}_high"] * (1.0 + 1e-6)).all()


def test_an_end_of_the_range_has_input_of_porepy_where_vm_is_determined(ranged):
    assert {"porepy_closes_more.json"} <= set(contents(ranged[0]))


def test_a_report_of_a_joint_with_a_range_is_written(ranged, command):
    assert command("report", ranged[0])[0] == 0
    ny, nx = ranged[2]["cells_y_x"]
    page = (ranged[0] / "report.html").read_text()
    size = f"{nx * 0.5:g} x {ny * 0.5:g} mm ({nx} x {ny} cells of 0.5 mm)"
    assert f"the joint of {size} closes" in page
    assert "other programs are of cycle 1, the first loading" in page
    assert ranged[2]["exports_of"] == "cycle 1, the first loading"


def test_chord_and_tangent_stiffness_have_names_of_their_own(ranged):
    table = ranged[2]["table"]["cycle 1"]
    assert [title for title in table if "stiffness" in title] == ["net chord stiffness (MPa/mm)"]
    assert CURVES["normal_stiffness_net_MPa_per_mm"][0] == "net tangent stiffness kn (MPa/mm)"


def test_the_time_of_a_range_is_stated_when_the_joint_is_simulated(
    scans, tmp_path, command, undrawn, monkeypatch
):
    monkeypatch.setattr(scanned_joint, "ANNOUNCED", 0.0)
    stopped = Mock(side_effect=KeyboardInterrupt)
    monkeypatch.setattr(scanned_joint, "uncertainty_budget", stopped)
    words = [*scans, *WORDS, *COARSE, "--cycles", 1, "--output", tmp_path / "j"]
    _, out, _ = command("close", *words)
    count = len(stopped.call_args.args[0].variants)
    assert f"- the range takes {count} further simulations, together about " in out
    assert re.search(r"of processor time; with \d+ at the same time they take about \d", out)


def test_kernels_are_compiled_before_the_joint_whose_time_gives_that_of_the_range(
    scans, tmp_path, command, undrawn, monkeypatch
):
    order = Mock()
    monkeypatch.setattr(scanned_joint, "prepare_kernels", order.kernels)
    monkeypatch.setattr(scanned_joint, "seconds_of_range", order.seconds)
    order.seconds.return_value = 0.0
    monkeypatch.setattr(scanned_joint, "uncertainty_budget", Mock(side_effect=KeyboardInterrupt))
    run = scanned_joint.Simulation.run

    def watched(*given):
        order.run()
        return run(*given)

    monkeypatch.setattr(scanned_joint.Simulation, "run", watched)
    command("close", *scans, *WORDS, *COARSE, "--cycles", 1, "--output", tmp_path / "j")
    assert [call[0] for call in order.method_calls] == ["kernels", "run", "seconds"]


def test_the_time_on_the_screen_says_from_when_it_counts(ranged):
    assert re.search(r"success.*; .+ since the program started", ranged[1])


def test_all_files_are_of_the_joint_as_it_was_closed(scans, tmp_path, command):
    """Of the walls as registered, with the usual choices of the model."""
    assert command("close", *scans, *WORDS, *COARSE, "--output", tmp_path)[0] == 0
    answer, cycles = (pd.read_csv(tmp_path / f"{name}.csv") for name in ("answer", "cycles"))
    record = json.loads((tmp_path / "joint.json").read_text())
    results = {(row["cycle"], row["quantity"]): row for row in record["range"]}
    for cycle, rows in answer[answer.branch == "loading"].groupby("cycle"):
        last, of_cycle = rows.iloc[-1], cycles[cycles.cycle == cycle].iloc[0]
        for along, name in (
            ("closure_net_since_seating_mm", "max_closure_seated_net_mm"),
            ("mean_aperture_mm", "mean_aperture_at_max_mm"),
        ):
            assert last[along] == pytest.approx(of_cycle[name], rel=1e-4)
            assert results[cycle, name]["best"] == pytest.approx(of_cycle[name], rel=1e-6)
            assert last[f"{along}_low"] <= last[along] <= last[f"{along}_high"]
            assert record["table"][f"cycle {cycle}"][RANGED_RESULTS[name]].startswith(
                results[cycle, name]["text"].split()[0]
            )


def test_the_noise_of_each_scan_is_stated_apart_from_roughness_below_the_grid(
    scans, tmp_path, command
):
    command("close", *scans, *WORDS, *COARSE, "--cycles", 1, "--output", tmp_path)
    found = "\n".join(json.loads((tmp_path / "joint.json").read_text())["found"])
    for side in ("upper", "lower"):
        assert f"{side} wall: the noise of the scanner" in found
    assert "roughness too short for the grid" in found


STATED = {"--tolerance 0.05": 0.05, "--force-tolerance 1e-6": 0.02, "--breakage fixed_step": None}


@pytest.fixture(params=STATED)
def settings(request, tmp_path, monkeypatch, command):
    """What is stated on the command line, and the settings that the library is given."""
    stopped = functools.wraps(jc.close)(Mock(side_effect=jc.InputError("enough")))
    monkeypatch.setattr("jointclosure.cli.close.close", stopped)
    stated = ["--rock", "Granite", "--largest-radius", "20", *request.param.split()]
    command("close", "a.txt", "b.txt", "--output", tmp_path / "j", *stated)
    return request.param, stopped.call_args.kwargs


def test_settings_of_several_words_add_up(settings):
    words, closed = settings
    assert closed["choices"] == jc.Choices(largest_radius=0.02)
    assert STATED[words] in (None, closed["numerics"].tolerance)


def test_only_the_rule_of_breakage_replaces_resolved_breakage(settings):
    words, closed = settings
    usual = conditions.RESOLVED if STATED[words] else jc.Numerics()
    for name in ("breakage", "displacement_step", "later_breakage_step"):
        assert getattr(closed["numerics"], name) == getattr(usual, name)


ONE_CYCLE = [*WORDS, *COARSE, "--single", "--cycles", 1]
OBSERVED = {"snapshots.png", "geos.xml", "geos_gap.csv", "geos_aperture.csv"}


@pytest.fixture(scope="module")
def observed(scans, tmp_path_factory, shared_command):
    """The folder of a joint with flow and snapshots, and what is printed."""
    folder = tmp_path_factory.mktemp("observed") / "joint"
    with pytest.MonkeyPatch.context() as patch:
        leave_undrawn(patch)
        more = ["--snapshots", "0.5,1", "--flow", "--output", folder]
        code, out, err = shared_command("close", *scans, *ONE_CYCLE, *more)
    assert (code, err) == (0, "")
    return folder, out


def test_flow_and_snapshots_are_written_where_they_are_asked_for(observed):
    folder, out = observed
    assert re.search(r"cycle 1: along x 0\.\d+ \(flows\); along y ", out)
    history = read_netcdf(folder / "joint.nc")
    assert (history.hydraulic_aperture > 0.0).all()
    assert set(history.snapshot_stress.values) == {0.5e6, 1e6}
    assert "hydraulic_aperture_x_mm" in pd.read_csv(folder / "curves.csv")
    assert set(contents(folder)) >= OBSERVED


def test_of_another_joint_nothing_stays_but_what_someone_else_put_there(
    scans, observed, tmp_path, command, undrawn
):
    shutil.copytree(observed[0], tmp_path, dirs_exist_ok=True)
    (tmp_path / "notes.txt").write_text("mine")
    # from first touch on GEOS has no form
    words = [*scans, *ONE_CYCLE, "--output", tmp_path, "--seating", 0]
    _, out, _ = command("close", *words)
    listed = out.splitlines()[-1].partition(": ")[2].split(", ")
    assert sorted([*listed, "notes.txt", "written.json"]) == sorted(contents(tmp_path))
    assert not OBSERVED & set(contents(tmp_path))


@pytest.mark.slow
def test_both_walls_of_a_published_fracture_are_closed_with_defaults_for_granite(tmp_path):
    if not TWO_WALLS.is_dir():
        pytest.skip("the two walls are not here")
    files = TWO_WALLS / "side_b_top.txt", TWO_WALLS / "side_a_bottom.txt"
    words = [*files, "--units", "mm", "--rock", "granite", "--single", "--output", tmp_path / "j"]
    assert cli.main(["close", *map(str, words)]) == 0
    record = json.loads((tmp_path / "j/joint.json").read_text())
    assert record["status"] == "success"
    assert record["orientation"] == "common_frame"
    assert np.abs(np.subtract(record["cells_y_x"], 188)).max() <= 1
    motion, mismatch = record["motion"], record["mismatch_wavelength_mm"]
    assert motion["rotation_error_degrees"] < 0.1
    assert abs(motion["rotation_degrees"] + 0.25) < 2.0 * motion["rotation_error_degrees"]
    assert max(motion["shift_error_mm_x_y"]) < 0.1 * record["spacing_mm"]
    assert 2.0 < mismatch["low"] < mismatch["wavelength"] < mismatch["high"] < 10.0
    assert record["correlation"] > 0.95
    first, second = record["per_cycle"]["max_closure_seated_net_mm"]
    assert 0.0 < second < first < record["per_cycle"]["max_closure_mm"][0]


def test_a_joint_is_assessed_by_the_command_as_in_python(scans, tmp_path, command, undrawn):
    folder, words = tmp_path / "a", [*WORDS, "--cycles", 1, "--spacing", 1.5, "--within", 0.2]
    words += ["--stress", 0.5]
    code, out, _ = command("assess", *scans, *words, "--output", folder)
    assert code in (0, 1)
    assert "without soft peaks" in out
    assert {"differences.csv", "assessment.json", "assessment.png"} <= set(contents(folder))
    pair = registered(*(jc.read_scan(file, units="mm") for file in scans), 1.5e-3)
    load = {**LOAD, "rock": "granite", "spacing": pair.spacing, "cycles": 1}
    load["max_normal_stress"] = 0.5e6
    joint = jc.assess((pair.upper, pair.lower), within=0.2, workers=1, folder=folder, **load)
    written = pd.read_csv(folder / "differences.csv")
    pd.testing.assert_frame_equal(written, joint.differences, rtol=1e-12)


def test_contacts_that_overlap_by_more_than_the_void_are_warned_of(joint):
    closed = joint.history.copy()
    assert "Warning" not in summary(closed, joint.laws, stress_table(closed))[0]
    closed["mean_overlap"] = 1.01 * closed.mean_aperture
    text, record = summary(closed, joint.laws, stress_table(closed))
    assert text.count("contacts are pressed into each other by 0.") == closed.load_cycle.max()
    assert len(cautions(record["remarks"])) == closed.load_cycle.max()


def test_the_option_that_gives_transmissivity_is_named_where_apertures_are_printed(joint):
    text, _ = summary(joint.history, joint.laws, stress_table(joint.history))
    (line,) = (line for line in text.splitlines() if "--flow" in line)
    assert line.startswith("- apertures are mechanical; hydraulic aperture and transmissivity are")


def test_an_aperture_that_is_zero_within_rounding_is_shown_as_none(joint):
    shut = joint.history.copy()
    shut["mean_aperture"] = 1e-21 + 0.0 * shut.mean_aperture
    text, record = summary(shut, joint.laws, stress_table(shut), at=[1e6])
    assert "mm on average over all cells, and no aperture is left: the model of" in text
    assert record["table"]["cycle 1"][RANGED_RESULTS["mean_aperture_at_max_mm"]] == "0"
    assert record["at"][0]["mean aperture (mm)"] == "0"
    assert "e-18" not in text


RECORD = {"joint": "<ClosedJoint: granite, closes 1 mm>", "description": "granite, 9 x 8 cells"}


def test_a_report_lists_its_warnings_in_the_place_of_a_success():
    warned = RECORD | {"status": "success", "warnings": ["is the file incomplete?", "holes"]}
    about, first, second, model = report._notes(warned)
    assert about == "Granite, 9 x 8 cells."
    assert (first, second) == ("Is the file incomplete?", "Holes.")
    assert model.startswith("No fluid pressure")


def test_a_report_without_warnings_has_the_status_of_the_simulation():
    assert report._notes(RECORD | {"status": "success", "warnings": []})[1] == "Success."
    outside = RECORD | {"status": "success: outside_model_range", "warnings": []}
    assert report._notes(outside)[1] == (
        "The simulation ended as it should, but: outside of the range in which the model holds; "
        "contacts that cannot break (flat or locked) carried over 10 % of the force at a maximum."
    )
    failed = RECORD | {"status": "failed: cannot_equilibrate", "warnings": ["holes"]}
    assert report._notes(failed)[1] == "Failed: cannot_equilibrate."


def test_a_report_leads_to_the_files_for_other_programs(tmp_path):
    (tmp_path / "my joint").mkdir()
    for name in ("barton_bandis.dat", "porepy.json", "porepy_closes_less.json"):
        (tmp_path / "my joint" / name).touch()
    files = dict(report.files_of(tmp_path / "my joint", tmp_path))
    (constants,) = files["Barton-Bandis constants for UDEC and 3DEC"]
    assert constants == ("barton_bandis.dat", "my%20joint/barton_bandis.dat")
    assert [name for name, _ in files["Constants for PorePy"]] == [
        "porepy.json",
        "porepy_closes_less.json",
    ]
    assert len(files) == 2


def test_a_figure_of_a_report_can_be_read_on_a_narrow_screen(ranged, tmp_path, command):
    """It scrolls in its box, at a width by the pixels of the picture."""
    folder = shutil.copytree(ranged[0], tmp_path / "j")
    for picture in folder.glob("*.png"):
        Image.new("RGB", (1000, 500)).save(picture)
    assert command("report", folder)[0] == 0
    page = (folder / "report.html").read_text()
    assert page.count('width="1000" height="500" style="--readable: 550px"') == page.count("<img")
    assert "?." not in page


def test_a_value_that_is_so_by_definition_has_no_range():
    curves = pd.DataFrame({"aperture": [0.0, 0.2], "aperture_low": [0.0, 0.1]})
    curves["aperture_high"] = [0.0, 0.3]
    assert list(with_bands(curves, "aperture", 2)) == ["0", "0.20 (0.10 to 0.30)"]

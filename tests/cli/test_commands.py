"""Commands give what the library gives (for `close` see test_close)."""

import json

import numpy as np
import pandas as pd
import pytest

import jointclosure as jc
from jointclosure.cli import doctor
from jointclosure.joint.simulation import Simulation
from jointclosure.joint.status import STATUSES
from jointclosure.storage.netcdf import read_netcdf
from jointclosure.walls.jrc import RELATIONS
from tests.joints import COARSE, SPACING

SMALL = ["--cells", "12x14", "--max-normal-stress", 2, "--seating-stress", 0.2]
BY_NUMBERS = ["--youngs-modulus", 78, "--poisson-ratio", 0.2, "--strength", 165, "--jrc", 8]


def test_a_rock_by_its_name_or_its_numbers_closes_as_by_the_library(tmp_path, command):
    for path, rock in (("name.nc", ["--rock", "dolerite"]), ("numbers.nc", BY_NUMBERS)):
        words = [*rock, *SMALL, "--seed", 3, "--output", tmp_path / path]
        code, out, err = command("simulate", *words)
        assert (code, err) == (0, "")
        assert "cycle 2" in out
    name, numbers = (read_netcdf(tmp_path / path) for path in ("name.nc", "numbers.nc"))
    walls = jc.wall_pair(8.0, (14, 12), 0.25e-3, seed=3)
    load = {"max_normal_stress": 2e6, "seating_stress": 0.2e6}
    closed = jc.simulate(*walls, spacing=0.25e-3, rock=jc.Rock(78e9, 0.2, 165e6), **load)
    for variable in closed.data_vars:
        np.testing.assert_array_equal(name[variable], closed[variable])
        np.testing.assert_array_equal(numbers[variable], closed[variable])
    assert json.loads(name.attrs["settings"])["rock"]["youngs_modulus"] == 78e9
    assert name.attrs["source_digest"]


@pytest.fixture(scope="module")
def elastic(tmp_path_factory, shared_command):
    """Files and what is printed of a joint with fewer effects and points, and a picture."""
    folder = tmp_path_factory.mktemp("elastic")
    words = [*SMALL, "--cycles", 1, "--without", "breakage", "gouge", "soft_peaks"]
    words += ["--curve-points", 7, "--picture", folder / "a.png", "--output", folder / "a.nc"]
    code, out, err = shared_command("simulate", "--rock", "slate", *words)
    assert (code, err) == (0, "")
    return folder, out


def test_a_picture_is_drawn_where_it_is_asked_for(elastic):
    assert (elastic[0] / "a.png").stat().st_size > 5000


def test_effects_that_are_left_out_are_off(elastic):
    closed = read_netcdf(elastic[0] / "a.nc")
    assert json.loads(closed.attrs["effects"])["breakage"] is False


def test_stated_settings_are_heeded(elastic):
    folder, out = elastic
    closed = read_netcdf(folder / "a.nc")
    # 7 stresses and that of seating, up from first touch and down again
    assert closed.sizes["step"] == 1 + 8 + 8
    assert "cycle 2" not in out


def test_a_failed_simulation_ends_with_its_status_in_words(command, monkeypatch):
    run = Simulation.run

    def failing(*given):
        closed = run(*given)
        closed["status"] = closed.status.copy(data=np.int16(64 + 2))
        return closed

    monkeypatch.setattr(Simulation, "run", failing)
    code, out, _ = command("simulate", "--rock", "slate", *SMALL)
    assert code == 1
    assert f"failed: {STATUSES[2].words}, {STATUSES[64].words}" in out
    for flag in (STATUSES[2], STATUSES[64]):  # what to do is on the screen
        assert f"- {flag.meaning}; {flag.remedy} (status {flag.name})\n" in out


def test_a_joint_that_ended_well_outside_of_the_model_says_so_in_words(command, monkeypatch):
    run = Simulation.run

    def outside(*given):
        closed = run(*given)
        closed["status"] = closed.status.copy(data=np.int16(2))
        return closed

    monkeypatch.setattr(Simulation, "run", outside)
    code, out, _ = command("simulate", "--rock", "slate", *SMALL)
    assert code == 0
    assert "ended as it should, but: outside of the range in which the model holds" in out
    assert "success: outside_model_range" not in out


OF_CURVE = ["--rock", "granite", "--jrc", "10", "--cells", "12", "--surfaces", "4"]


OF_REGION = ["--shifts", 1, "--crushed-strength-ratios", 0.8]
REGION = {"shifts": (1,), "crushed_strength_ratios": (0.8,)}


@pytest.fixture(
    scope="module",
    params=[("fit", [], {}, "fit"), ("validate", OF_REGION, REGION, "region")],
    ids=["fit", "validate"],
)
def judged(request, inputs, tmp_path_factory, shared_command):
    """Name of a command that judges a curve, its files and print, and the library's after it."""
    name, more, stated, made = request.param
    folder = tmp_path_factory.mktemp(name)
    words = [inputs / "lab.csv", *OF_CURVE, "--tolerance", 0.1, *more, "--output", folder]
    code, out, err = shared_command(name, *words)
    assert (code, err) == (0, "")
    lines = []
    stated = stated | {"rock": "granite", "jrc": 10.0, "shape": (12, 12), "surfaces": 4}
    stated |= {"numerics": COARSE, "cache": folder / "joints"}
    stated |= {"report": lines.append} if name == "validate" else {}
    return name, folder / made, out, getattr(jc, name)(inputs / "lab.csv", **stated), lines


def test_a_curve_is_judged_as_by_the_library(judged):
    name, made, out, found, _ = judged
    assert all(f"- {line}" in out for line in found.sentences())
    record = json.loads(made.with_suffix(".json").read_text())
    assert json.loads(record["provenance"]["settings"])["shape"] == [12, 12]
    if name == "fit":
        assert (record["p_value"], record["assumed"]) == (found.p_value, found.assumed)
    else:
        table = pd.read_csv(made.with_suffix(".csv"))
        pd.testing.assert_frame_equal(table, found.table(), rtol=1e-9)


def test_a_judged_curve_is_drawn(judged):
    assert judged[1].with_suffix(".png").stat().st_size > 20000


def test_joints_that_a_command_closed_are_kept(judged):
    assert not any(line.startswith("closed") for line in judged[4])


@pytest.fixture(scope="module")
def measured(inputs, tmp_path_factory, shared_command):
    """What is printed of the roughness of a wall, its table, and its picture."""
    folder = tmp_path_factory.mktemp("roughness")
    table, picture = folder / "measures.csv", folder / "wall.png"
    words = ["--units", "mm", "--scan-spacing", "0.25", "--table", table, "--picture", picture]
    code, out, _ = shared_command("roughness", inputs / "wall.npy", *words)
    assert code == 0
    return out, pd.read_csv(table).set_index("measure"), picture


def test_roughness_prints_every_measure_of_its_table(measured):
    out, table, _ = measured
    assert "48 x 40 cells of 0.25 mm (x, y); mean plane removed" in out
    for name in table.index:
        relation = RELATIONS.get(name.removeprefix("JRC, "))
        shown = relation.title if relation else name.replace("stigsson_mas_ivars", "Stigsson & Mas")
        assert shown in out


def test_roughness_of_a_wall_is_the_one_it_was_made_with(measured):
    value = measured[1].value["JRC, yu_vayssade_linear_0.25mm"]
    assert value == pytest.approx(9.0, abs=0.2)


def test_roughness_has_a_picture(measured):
    assert measured[2].stat().st_size > 20000


@pytest.mark.parametrize("step_mm", [0.0, 0.1])
def test_roughness_of_an_inclined_wall_names_the_rounding_of_its_file(step_mm, tmp_path, command):
    wall = 1e3 * jc.wall_pair(9.0, (40, 48), SPACING, seed=1)[0]
    wall += 0.3 * 0.25 * np.indices(wall.shape)[1]
    np.save(tmp_path / "a.npy", np.round(wall / step_mm) * step_mm if step_mm else wall)
    words = ["--units", "mm", "--scan-spacing", "0.25"]
    code, out, _ = command("roughness", tmp_path / "a.npy", *words)
    assert code == 0
    assert "the scan was turned until it lies level" in out
    assert ("heights are multiples of 100 um" in out) == (step_mm > 0.0)
    assert "\nNote: " in out
    assert "\nWarning: interpolation onto the grid smoothed the wall" in out
    assert "Note: Warning" not in out


@pytest.fixture
def sound(tmp_path, monkeypatch):
    """An empty folder, one thread, and no start of Snakemake, which takes seconds."""
    monkeypatch.chdir(tmp_path)
    for name in doctor.THREADS:
        monkeypatch.setenv(name, "1")
    monkeypatch.setattr(doctor, "_snakemake", lambda folder: ("snakemake", "starts", ""))
    monkeypatch.setattr(doctor.os, "sched_getaffinity", lambda process: {0, 1}, raising=False)


def test_a_sound_environment_has_no_advice(sound, tmp_path, command):
    code, out, _ = command("doctor")
    assert (code, "no problems" in out, "->" in out) == (0, True, False)
    for what in ("python", "packages", "cores", "threads", "memory", "compiled kernels", "results"):
        assert f"{what}:" in out
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("stored", "said"),
    [
        ((158, 158), "all 158 are compiled"),
        ((3, 158), "3 of 158 are compiled; a joint that needs others takes"),
        ((3, None), "3 are compiled (how many there are is not known); a joint"),
        ((0, None), "none is compiled"),
    ],
)
def test_the_doctor_compares_compiled_kernels_with_their_number(
    stored, said, sound, monkeypatch, command
):
    monkeypatch.setattr(doctor, "stored_kernels", lambda: stored)
    code, out, _ = command("doctor")
    assert code == 0
    assert said in out


def test_threads_set_otherwise_get_an_advice(sound, monkeypatch, command):
    for name in doctor.THREADS:  # as in any shell: make sets them
        monkeypatch.delenv(name)
    assert command("doctor")[0] == 0
    monkeypatch.setenv("MKL_NUM_THREADS", "2")
    code, out, _ = command("doctor")
    assert code == 1
    assert "OMP_NUM_THREADS=unset" in out
    assert "set all to 1" in out

"""Commands find, print and store what the library does (`close`: see test_close)."""

import json

import numpy as np
import pandas as pd
import pytest

import jointclosure as jc
from jointclosure.cli import doctor
from jointclosure.joint.simulation import close_checked
from jointclosure.joint.status import STATUSES
from jointclosure.storage.netcdf import read_netcdf
from tests.joints import COARSE, SPACING

SMALL = ["--cells", "12x14", "--max-normal-stress", 2, "--seating-stress", 0.2]
BY_NUMBERS = ["--youngs-modulus", 78, "--poisson-ratio", 0.2, "--strength", 165, "--jrc", 8]


def test_a_rock_by_name_and_by_its_numbers_close_alike_as_the_library_does(tmp_path, command):
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


def test_a_picture_is_drawn_and_effects_and_settings_are_heeded(tmp_path, command):
    words = [*SMALL, "--cycles", 1, "--without", "breakage", "gouge", "soft_peaks"]
    words += ["--curve-points", 7, "--picture", tmp_path / "a.png", "--output", tmp_path / "a.nc"]
    code, out, err = command("simulate", "--rock", "slate", *words)
    assert (code, err) == (0, "")
    assert (tmp_path / "a.png").stat().st_size > 5000
    closed = read_netcdf(tmp_path / "a.nc")
    assert json.loads(closed.attrs["effects"])["breakage"] is False
    # 7 stresses and that of seating, up from first touch and down again
    assert closed.sizes["step"] == 1 + 8 + 8
    assert "cycle 2" not in out


def test_a_failed_simulation_has_its_status_in_words_and_fails(command, monkeypatch):
    def failing(*given):
        closed = close_checked(*given)
        closed["status"] = closed.status.copy(data=np.int16(64 + 2))
        return closed

    monkeypatch.setattr("jointclosure.joint.simulation.close_checked", failing)
    code, out, _ = command("simulate", "--rock", "slate", *SMALL)
    assert code == 1
    assert "failed: outside_model_range, rigid_contact" in out
    for flag in (STATUSES[2], STATUSES[64]):  # what to do is on the screen
        assert f"- {flag.name}: {flag.meaning}; {flag.remedy}\n" in out


OF_CURVE = ["--rock", "granite", "--jrc", "10", "--cells", "12", "--surfaces", "4"]


OF_REGION = ["--shifts", 1, "--crushed-strength-ratios", 0.8]
REGION = {"shifts": (1,), "crushed_strength_ratios": (0.8,)}


@pytest.mark.parametrize(
    ("name", "more", "stated", "made"),
    [("fit", [], {}, "fit"), ("validate", OF_REGION, REGION, "region")],
    ids=["fit", "validate"],
)
def test_a_curve_is_fitted_and_validated_as_by_the_library_and_joints_are_kept(
    inputs, tmp_path, command, name, more, stated, made
):
    words = [inputs / "lab.csv", *OF_CURVE, "--tolerance", 0.1, *more, "--output", tmp_path]
    code, out, err = command(name, *words)
    assert (code, err) == (0, "")
    lines = []
    stated = stated | {"rock": "granite", "jrc": 10.0, "shape": (12, 12), "surfaces": 4}
    stated |= {"numerics": COARSE, "cache": tmp_path / "joints"}
    stated |= {"report": lines.append} if name == "validate" else {}
    found = getattr(jc, name)(inputs / "lab.csv", **stated)
    assert not any(line.startswith("closed") for line in lines)  # by the command
    assert all(f"- {line}" in out for line in found.sentences())
    record = json.loads((tmp_path / f"{made}.json").read_text())
    assert json.loads(record["provenance"]["settings"])["shape"] == [12, 12]
    assert (tmp_path / f"{made}.png").stat().st_size > 20000
    if name == "fit":
        assert (record["p_value"], record["assumed"]) == (found.p_value, found.assumed)
    else:
        table = pd.read_csv(tmp_path / "region.csv")
        pd.testing.assert_frame_equal(table, found.table(), rtol=1e-9)


def test_roughness_prints_every_measure_and_writes_table_and_picture(inputs, tmp_path, command):
    table, picture = tmp_path / "measures.csv", tmp_path / "wall.png"
    words = ["--units", "mm", "--scan-spacing", "0.25", "--table", table, "--picture", picture]
    code, out, _ = command("roughness", inputs / "wall.npy", *words)
    assert code == 0
    assert "40 x 48 cells (y, x) of 0.25 mm; mean plane removed" in out
    frame = pd.read_csv(table).set_index("measure")
    assert all(name in out for name in frame.index)
    assert frame.value["JRC, yu_vayssade_linear_0.25mm"] == pytest.approx(9.0, abs=0.2)
    assert picture.stat().st_size > 20000


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


def test_threads_set_otherwise_get_an_advice(sound, monkeypatch, command):
    for name in doctor.THREADS:  # as in any shell: make sets them
        monkeypatch.delenv(name)
    assert command("doctor")[0] == 0
    monkeypatch.setenv("MKL_NUM_THREADS", "2")
    code, out, _ = command("doctor")
    assert code == 1
    assert "OMP_NUM_THREADS=unset" in out
    assert "set all to 1" in out

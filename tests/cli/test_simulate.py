"""`jointclosure simulate` closes and stores what the library does."""

import json

import numpy as np

import jointclosure as jc
from jointclosure.joint.simulation import simulate_by
from jointclosure.storage.netcdf import read_netcdf

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
        closed = simulate_by(*given)
        closed["status"] = closed.status.copy(data=np.int16(64 + 2))
        return closed

    monkeypatch.setattr("jointclosure.joint.simulation.simulate_by", failing)
    code, out, _ = command("simulate", "--rock", "slate", *SMALL)
    assert code == 1
    assert "failed: outside_model_range, rigid_contact" in out

"""`jointclosure simulate`: what it takes, prints, writes, and refuses in one line."""

import json

import numpy as np
import pytest

import jointclosure as jc
from jointclosure.cli import main as cli
from jointclosure.joint.simulation import simulate_by
from jointclosure.storage.netcdf import read_netcdf

SMALL = ["--cells", "12x14", "--stress", "2", "--seating", "0.2"]
BY_NUMBERS = ["--youngs-modulus", "78", "--poisson-ratio", "0.2", "--strength", "165", "--jrc", "8"]


def printed(capsys, *words):
    code = cli.main(["simulate", *map(str, words)])
    return code, *capsys.readouterr()


def test_a_rock_by_name_and_by_its_numbers_close_alike_as_the_library_does(tmp_path, capsys):
    for path, rock in (("name.nc", ["--rock", "dolerite"]), ("numbers.nc", BY_NUMBERS)):
        code, out, err = printed(capsys, *rock, *SMALL, "--seed", 3, "--output", tmp_path / path)
        assert (code, err) == (0, "")
        assert "cycle 2" in out
    name, numbers = (read_netcdf(tmp_path / path) for path in ("name.nc", "numbers.nc"))
    walls = jc.wall_pair(8.0, (14, 12), 0.25e-3, seed=3)
    closed = jc.simulate(
        *walls,
        spacing=0.25e-3,
        rock=jc.Rock(78e9, 0.2, 165e6),
        max_normal_stress=2e6,
        seating_stress=0.2e6,
    )
    for variable in closed.data_vars:
        np.testing.assert_array_equal(name[variable], closed[variable])
        np.testing.assert_array_equal(numbers[variable], closed[variable])
    assert json.loads(name.attrs["settings"])["rock"]["youngs_modulus"] == 78e9
    assert name.attrs["source_digest"]


def test_a_picture_is_drawn_and_effects_and_settings_are_heeded(tmp_path, capsys):
    words = [*SMALL, "--cycles", 1, "--without", "breakage", "gouge", "soft_peaks"]
    words += ["--curve-points", 7, "--picture", tmp_path / "a.png"]
    code, out, err = printed(capsys, "--rock", "slate", *words, "--output", tmp_path / "a.nc")
    assert (code, err) == (0, "")
    assert (tmp_path / "a.png").stat().st_size > 5000
    closed = read_netcdf(tmp_path / "a.nc")
    assert json.loads(closed.attrs["effects"])["breakage"] is False
    # 7 stresses and that of seating, up from first touch and down again
    assert closed.sizes["step"] == 1 + 8 + 8
    assert out.count("cycle ") == 1


def test_a_failed_simulation_is_said_and_fails(capsys, monkeypatch):
    def failing(*given):
        closed = simulate_by(*given)
        closed["status"] = closed.status.copy(data=np.int16(64 + 2))
        return closed

    monkeypatch.setattr("jointclosure.joint.simulation.simulate_by", failing)
    code, out, _ = printed(capsys, "--rock", "slate", *SMALL)
    assert code == 1
    assert "failed: outside_model_range, rigid_contact" in out


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (
            [],
            "without --rock (such as --rock granite): --youngs-modulus, --poisson-ratio",
        ),
        (["--rock", "dolorite"], "--rock dolorite: must be one of dolerite, siltstone"),
        (["--rock", "Granite"], "--rock Granite: has no roughness, --jrc must be given"),
        (["--rock", "slate", "--tolerance", "0.01"], "--tolerance: has no effect on fixed steps"),
        (
            ["--rock", "slate", "--jrc", "30"],
            "jrc = 30.0: yu_vayssade_linear_0.25mm holds from 0 to 20",
        ),
        (["--rock", "slate", "--stress", "10e6"], "max_normal_stress = 10000000000000.0 Pa: not"),
        (["--rock", "slate", "--seed", "-1"], "--seed = -1: must be 0 or above"),
        (["--rock", "slate", "--output", "joint.txt"], "joint.txt: must end in .nc"),
        (["--rock", "slate", "--output", "no/joint.nc"], "no/joint.nc: folder no not found"),
    ],
)
def test_bad_input_is_one_line_before_anything_is_computed(words, message, capsys, monkeypatch):
    monkeypatch.setattr("jointclosure.joint.simulation.simulate_by", None)
    code, out, err = printed(capsys, *words)
    assert (code, out) == (2, "")
    assert message in err
    assert err.count("\n") == 1


@pytest.mark.parametrize("words", [["--cells", "ten"], ["--without", "gravity"], ["x"]])
def test_bad_arguments_are_one_line_that_names_the_help(words, capsys):
    with pytest.raises(SystemExit) as stop:
        cli.main(["simulate", *words])
    err = capsys.readouterr().err
    assert stop.value.code == 2
    assert err.count("\n") == 1
    assert "jointclosure simulate --help)" in err or "jointclosure --help)" in err

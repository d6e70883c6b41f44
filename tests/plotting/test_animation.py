"""Moving pictures of a joint being crushed."""

import itertools

import numpy as np
import xarray as xr
from PIL import Image

import jointclosure as jc
from jointclosure.cli import main as cli
from jointclosure.plotting import snapshots
from jointclosure.plotting.snapshots import STRESSES, animated_stresses, crushing_animation
from jointclosure.storage.figures import save_animation
from jointclosure.storage.netcdf import read_netcdf
from tests.joints import DOLERITE, SPACING


def closed(**more):
    walls = jc.wall_pair(8.0, (12, 16), SPACING, seed=3)
    return jc.simulate(*walls, spacing=SPACING, rock=DOLERITE, max_normal_stress=5e6, **more)


def test_each_snapshot_is_a_picture_that_differs_from_the_one_before(tmp_path):
    joint = closed(snapshots=[0.0, 1e6, 5e6], cycles=1)
    save_animation(crushing_animation(joint, "a joint"), tmp_path / "joint.gif")
    frames = []
    with Image.open(tmp_path / "joint.gif") as pictures:
        for number in range(pictures.n_frames):
            pictures.seek(number)
            frames.append(np.asarray(pictures.convert("L"), dtype=float))
    shown = np.unique(joint.snapshot_step.values)  # Pillow joins pictures that are alike
    assert len(frames) == shown.size > 3
    for one, other in itertools.pairwise(frames):
        assert np.abs(one - other).max() > 50.0


def test_animated_stresses_lie_close_where_joints_close_fast():
    stresses = animated_stresses(16e6)
    assert stresses[0] == 0.0
    assert stresses[-1] == 16e6
    assert len(stresses) == STRESSES + 1
    assert (np.diff(stresses, 2) > 0.0).all()


def test_the_animation_leaves_no_trace_in_the_file(tmp_path, monkeypatch):
    monkeypatch.setattr(snapshots, "STRESSES", 4)
    files = [tmp_path / "one.nc", tmp_path / "other.nc"]
    stated = ["simulate", "--rock", "dolerite", "--cells", "12", "--stress", "3", "--cycles", "1"]
    assert cli.main([*stated, "--output", str(files[0]), "--snapshots", "1"]) == 0
    gif = tmp_path / "joint.gif"
    more = ["--output", str(files[1]), "--snapshots", "1", "--animation", str(gif)]
    assert cli.main([*stated, *more]) == 0
    with Image.open(gif) as pictures:
        assert pictures.n_frames > 2
    xr.testing.assert_equal(*map(read_netcdf, files))

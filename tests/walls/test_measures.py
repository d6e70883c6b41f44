"""What is measured of a wall is what it was made with."""

import os
import re
from pathlib import Path

import numpy as np
import pytest

import jointclosure as jc
from jointclosure.statistics.randomness import generator
from jointclosure.walls.measured import wall_on_grid
from jointclosure.walls.measures import hurst_of, mean_curvature, measure_wall, peak_cells
from jointclosure.walls.roughness import RELATIONS, bearing_depths, rms_slope
from jointclosure.walls.scans import read_scan
from jointclosure.walls.synthesis import synthetic_wall
from tests.joints import SPACING, bump

ROOT = Path(__file__).parents[2]


SCAN = Path(
    os.environ.get("JOINTCLOSURE_SCAN") or ROOT.parent / "shared/data/foliation_joint_0p25mm.npz"
)

ROOT = Path(__file__).parents[2]


def measured(wall):
    return {m.name: m for m in measure_wall(wall, SPACING, resamples=100)}


def test_every_measure_lies_within_its_interval_and_the_slope_is_the_walls():
    wall = jc.wall_pair(9.0, (70, 60), SPACING, seed=2)[0]
    found = measured(wall)
    assert all(m.low < m.value < m.high for m in found.values())
    assert found["Z2 along x"].value == pytest.approx(
        np.sqrt(np.mean(np.diff(wall, axis=1) ** 2)) / SPACING, rel=1e-12
    )
    assert found["rms height"].value == pytest.approx(1e3 * wall.std(), rel=1e-12)


@pytest.mark.parametrize("name", RELATIONS)
def test_each_relation_gives_the_jrc_that_a_wall_was_made_with(name):
    relation = RELATIONS[name]
    values = []
    for seed in range(3):
        wall = jc.wall_pair(9.0, (32, 32), relation.interval, seed, jrc_relation=name)[0]
        found = {m.name: m for m in measure_wall(wall, relation.interval, resamples=10)}
        values.append(found[f"JRC, {name}"].value)
        assert f"at its {1e3 * relation.interval:g} mm; holds" in found[f"JRC, {name}"].remark
    assert np.mean(values) == pytest.approx(9.0, abs=0.3)


@pytest.mark.parametrize("hurst", [0.6, 1.0])
def test_the_hurst_exponent_is_recovered_and_its_interval_covers_it(hurst):
    walls = [synthetic_wall(0.2, (100, 100), SPACING, hurst, generator(s)) for s in range(16)]
    assert np.mean([hurst_of(wall) for wall in walls]) == pytest.approx(hurst, abs=0.04)
    intervals = [measured(wall)["H, both directions"] for wall in walls[:5]]
    assert sum(m.low <= hurst <= m.high for m in intervals) >= 4


def test_a_cap_is_one_peak_of_its_own_curvature():
    wall = bump((41, 41), 10e-3)
    assert np.argwhere(peak_cells(wall)).tolist() == [[20, 20]]
    np.testing.assert_allclose(mean_curvature(wall, SPACING)[1:-1, 1:-1], 100.0, rtol=1e-9)
    found = measured(wall)
    assert found["mean curvature of peaks"].value == pytest.approx(0.1, rel=1e-9)
    assert found["rms curvature along x"].value == pytest.approx(0.1, rel=1e-9)
    assert found["peaks"].value == pytest.approx(1.0 / (39 * 39 * 0.25**2), rel=1e-9)


def test_missing_cells_are_left_out_of_the_measures():
    wall = jc.wall_pair(9.0, (90, 80), SPACING, seed=2)[0]
    holed = wall.copy()
    holed[:30, :30] = np.nan
    whole, part = measured(wall), measured(holed)
    for name, found in part.items():
        assert found.low < whole[name].value < found.high, name


def test_a_wall_too_small_to_be_measured_is_refused():
    with pytest.raises(jc.InputError, match=r"20 x 40 cells .* need at least 24"):
        measure_wall(np.zeros((20, 40)), SPACING)


def test_depths_are_those_of_sorted_heights():
    upper, lower = jc.wall_pair(8, (30, 40), 0.25e-3, 1)
    highest = np.sort((upper + lower).ravel())[::-1]
    for cells in (1, 2, 12, 600, 1200):
        found = bearing_depths(upper + lower, cells / 1200)
        assert found == pytest.approx(highest[0] - highest[cells - 1], abs=1e-18)


def test_the_samples_run_and_make_the_example_wall(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    text = (ROOT / "config/walls/README.md").read_text(encoding="utf-8")
    samples = [c for c in re.findall(r"```python\n(.*?)```", text, re.S) if "example_wall" in c]
    assert len(samples) == 2
    for sample in samples:
        exec(compile(sample, "config/walls/README.md", "exec"), {})
    assert "Z2 along x" in capsys.readouterr().out
    made, kept = (
        np.load(folder / "example_wall.npz", allow_pickle=False)
        for folder in (tmp_path, ROOT / "config/walls")
    )
    with made, kept:
        assert sorted(made.files) == sorted(kept.files)
        # heights are rounded to micrometres; on another machine the last one may differ
        np.testing.assert_allclose(made["Z_mm"], kept["Z_mm"], atol=1.1e-3)


@pytest.mark.skipif(not SCAN.is_file(), reason="the scanned wall is not part of the project")
def test_the_measured_wall_has_the_roughness_that_it_was_published_with():
    scan = read_scan(SCAN, variable="patch63_mm")
    wall = wall_on_grid(scan, SPACING)
    assert wall.shape == (63, 63)
    # rms 0.255 mm and Z2 of 0.115 and 0.152 along its axes, as its README has them
    assert 1e3 * wall.std() == pytest.approx(0.255, abs=5e-4)
    slopes = sorted(np.sqrt(np.mean(np.diff(wall, axis=a) ** 2)) / SPACING for a in (0, 1))
    assert slopes == pytest.approx([0.115, 0.152], abs=6e-4)
    assert rms_slope(wall, SPACING) == pytest.approx(measured(wall)["Z2, both directions"].value)


def test_rigid_walls_overlap_in_that_share_at_that_closure():
    upper, lower = jc.wall_pair(8, (30, 40), 0.25e-3, 2)
    gap = (upper + lower).max() - (upper + lower)
    closure = bearing_depths(upper + lower, 0.05)
    assert np.mean(gap <= closure * (1 + 1e-12)) == pytest.approx(0.05, abs=0.5 / gap.size)

"""Joints of finished points survive an interruption, and no others are taken for them."""

import pytest
import xarray as xr

from studies.frame import kept_points
from studies.frame.cases import block_settings, cases_of
from studies.frame.kept_points import KeptPoints
from studies.frame.settings import Point, walls_of
from studies.frame.simulation import close_points
from tests.studied import study_of

NAMES = ("max_closure", "stiffness_net")
STUDY = study_of({
    "grid": {"cells_x": 9, "cells_y": 8}, "effects": {"breakage": False, "gouge": False},
    "study": {"rocks": ["slate"], "realizations": 2, "pool": None},
    "statistics": {"control_variates": None}, "surface": {"roll_off_mm": None},
})  # fmt: skip
SETTINGS = block_settings(STUDY, cases_of(STUDY)[0], range(2))
POINTS = [
    Point({"rock": "slate", "variant": name}, SETTINGS.under(cycles=cycles))
    for name, cycles in (("as stated", 2), ("one cycle", 1), ("three cycles", 3))
]
WALLS = list(walls_of(SETTINGS))


@pytest.fixture
def closed(monkeypatch):
    """Variants that are closed; those that are named in ``stops`` interrupt."""
    seen = []

    def recorded(points, *words):
        (point,) = points
        seen.append(point.coordinates["variant"])
        if seen[-1] in recorded.stops:
            raise KeyboardInterrupt
        return close_points(points, *words)

    recorded.stops = []
    recorded.seen = seen
    monkeypatch.setattr(kept_points, "close_points", recorded)
    return recorded


def in_folder(folder, key="key", walls=WALLS):
    return KeptPoints(folder, key).closed(POINTS, NAMES, lambda line: None, walls)


def without_times(joints):
    return joints.drop_vars("timing_simulation")


def test_an_interrupted_rock_goes_on_with_its_finished_variants(tmp_path, closed):
    closed.stops = ["three cycles"]
    with pytest.raises(KeyboardInterrupt):
        in_folder(tmp_path / "slate")
    closed.stops = []
    closed.seen.clear()
    joints = in_folder(tmp_path / "slate")
    assert closed.seen == ["three cycles"]
    whole = close_points(POINTS, NAMES, walls=WALLS)
    xr.testing.assert_equal(without_times(joints), without_times(whole))
    KeptPoints(tmp_path / "slate", "key").remove()
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("change", ["key", "walls", "damage"])
def test_joints_of_other_settings_or_walls_are_closed_again(tmp_path, closed, change):
    in_folder(tmp_path)
    closed.seen.clear()
    in_folder(tmp_path)
    assert closed.seen == []
    if change == "damage":
        (tmp_path / "0.nc").write_bytes((tmp_path / "0.nc").read_bytes()[:-100])
    key = "other" if change == "key" else "key"
    in_folder(tmp_path, key, WALLS[::-1] if change == "walls" else WALLS)
    assert (
        closed.seen
        == [point.coordinates["variant"] for point in POINTS][: 1 + 2 * (change != "damage")]
    )

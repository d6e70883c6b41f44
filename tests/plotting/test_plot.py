"""`jointclosure.plotting.plot`: axes in and out."""

import matplotlib.pyplot as plt
import numpy as np
import pytest

import jointclosure as jc
from tests.joints import DOLERITE, SPACING


@pytest.fixture(scope="module")
def walls():
    return jc.wall_pair(8.0, (16, 20), SPACING, seed=3)


@pytest.fixture(scope="module")
def joint(walls):
    return jc.simulate(
        *walls, spacing=SPACING, rock=DOLERITE, max_normal_stress=5e6, seating_stress=0.5e6,
        snapshots=[1e6, 5e6],
    )  # fmt: skip


def test_each_picture_is_drawn_on_the_axes_that_are_given(joint, walls):
    draws = {
        "curves": (joint,), "stiffness": (joint,), "aperture": (joint,), "contacts": (joint,),
        "damage": (joint,), "wall": (walls[0], SPACING),
    }  # fmt: skip
    assert sorted([*draws, "walls"]) == jc.plot.__all__
    for name, stated in draws.items():
        axes = plt.figure().add_subplot()
        assert getattr(jc.plot, name)(*stated, axes=axes) is axes
        assert axes.has_data(), name
        assert axes.get_xlabel(), name
    axes = plt.figure().add_subplot()
    assert jc.plot.walls(*walls, spacing=SPACING, axes=axes) is axes
    assert len(axes.lines) == 3


def test_without_axes_a_figure_is_made_and_the_notebook_keeps_its_style(joint):
    before = dict(plt.rcParams)
    axes = jc.plot.curves(joint)
    assert axes.figure.number in plt.get_fignums()
    assert dict(plt.rcParams) == before


@pytest.mark.parametrize("since", ["touch", "seating", "cycle"])
def test_curves_since_anything_but_touch_start_at_zero_in_every_cycle(joint, since):
    axes = jc.plot.curves(joint, since=since)
    loading = [line for line in axes.lines if line.get_label().endswith(" loading")]
    assert len(loading) == 2
    starts = [line.get_xdata()[0] for line in loading]
    step = 1e3 * jc.Numerics().displacement_step
    if since == "touch":
        assert starts[1] > 5.0 * step
    else:
        assert all(abs(start) < 1e-12 for start in starts)
    assert {line.get_linestyle() for line in axes.lines} == {"-", "--"}


def test_maps_show_the_snapshot_that_is_asked_for(joint):
    for snapshot in (0, 1):
        axes = jc.plot.aperture(joint, snapshot)
        gap = 1e3 * np.maximum(joint.snapshot_gap.values[snapshot], 0.0)
        np.testing.assert_array_equal(axes.images[0].get_array(), gap)


def test_an_ensemble_is_drawn_with_its_mean(walls):
    ensemble = jc.simulate_ensemble(
        lambda seed: jc.wall_pair(8.0, (8, 8), SPACING, seed), seeds=range(3), workers=1,
        spacing=SPACING, rock=DOLERITE, max_normal_stress=1e6, cycles=1,
        effects=jc.Effects(*[False] * 5),
    )  # fmt: skip
    axes = jc.plot.curves(ensemble)
    mean = next(line for line in axes.lines if line.get_label() == "cycle 1, loading: mean")
    np.testing.assert_allclose(
        mean.get_xdata(), 1e3 * ensemble.closure.sel(branch="loading", cycle=1).mean("realization")
    )

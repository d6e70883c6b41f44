"""Figures show what they are given, and leave everything else alone."""

import itertools

import matplotlib.pyplot as plt
import numpy as np
import pytest
from matplotlib.colors import to_rgba
from PIL import Image

import jointclosure as jc
from jointclosure.cli import main as cli
from jointclosure.ensembles.quantities import CURVES
from jointclosure.joint.result_tables import stress_table
from jointclosure.plotting import snapshots
from jointclosure.plotting.joint import closure_curve, engineering_figure
from jointclosure.plotting.style import percent_ticks, subplots
from jointclosure.plotting.walls import HOLES, pair_figure
from jointclosure.storage.netcdf import read_netcdf
from jointclosure.walls.gridding import Scan
from jointclosure.walls.registration import registered
from tests.joints import DOLERITE, SPACING
from tests.processes import python

PROGRAM = """
import matplotlib
matplotlib.use("svg")
before = dict(matplotlib.rcParams)
from studies.paper import figures
from jointclosure.plotting import joint, snapshots, walls
figure = figures.equivalent_stress()
figure.savefig("figure.png")
changed = [key for key, value in matplotlib.rcParams.items() if value != before[key]]
assert changed == [], changed
import sys
assert "matplotlib.pyplot" not in sys.modules or not sys.modules["matplotlib.pyplot"].get_fignums()
"""


@pytest.fixture(autouse=True)
def close_figures():
    yield
    plt.close("all")


@pytest.fixture(scope="module")
def walls():
    return jc.wall_pair(8.0, (16, 20), SPACING, seed=3)


@pytest.fixture(scope="module")
def joint(walls):
    return jc.simulate(
        *walls, spacing=SPACING, rock=DOLERITE, max_normal_stress=5e6, seating_stress=0.5e6,
        snapshots=[0.0, 1e6, 5e6],
    )  # fmt: skip


def test_figures_leave_the_matplotlib_of_the_process_alone(tmp_path):
    python("-c", PROGRAM, cwd=tmp_path)
    assert (tmp_path / "figure.png").stat().st_size > 1000


def test_each_picture_is_drawn_on_the_axes_that_are_given_or_on_new_ones(joint, walls):
    draws = dict.fromkeys(("curves", "stiffness", "aperture", "contacts", "damage"), (joint,))
    draws["wall"] = walls[0], SPACING
    assert sorted([*draws, "walls"]) == jc.plot.__all__
    for name, stated in draws.items():
        axes = plt.figure().add_subplot()
        assert getattr(jc.plot, name)(*stated, axes=axes) is axes
        assert axes.has_data(), name
        assert axes.get_xlabel(), name
    axes = plt.figure().add_subplot()
    assert jc.plot.walls(*walls, spacing=SPACING, axes=axes) is axes
    assert len(axes.lines) == 3
    before = dict(plt.rcParams)  # of a notebook
    assert jc.plot.curves(joint).figure.number in plt.get_fignums()
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


def test_stresses_of_an_animation_are_close_where_joints_close_fast():
    stresses = snapshots.animated_stresses(16e6)
    assert (stresses[0], stresses[-1], len(stresses)) == (0.0, 16e6, snapshots.STRESSES + 1)
    assert (np.diff(stresses, 2) > 0.0).all()


@pytest.fixture(scope="module")
def animated(tmp_path_factory):
    """The file of a joint with one snapshot, and its animation."""
    folder = tmp_path_factory.mktemp("animated")
    file, gif = folder / "a.nc", folder / "joint.gif"
    words = ["simulate", "--rock", "dolerite", "--cells", "12", "--stress", "3", "--cycles", "1"]
    words += ["--output", str(file), "--snapshots", "1", "--animation", str(gif)]
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(snapshots, "STRESSES", 2)
        assert cli.main(words) == 0
    return file, gif


def test_an_animation_leaves_no_trace_in_the_file(animated):
    assert set(read_netcdf(animated[0]).snapshot_stress.values) == {1e6}


def test_snapshots_of_an_animation_are_pictures_that_differ(animated):
    frames = []
    with Image.open(animated[1]) as pictures:
        for number in range(pictures.n_frames):
            pictures.seek(number)
            frames.append(np.asarray(pictures.convert("L"), dtype=float))
    assert len(frames) > 2
    for one, other in itertools.pairwise(frames):
        assert np.abs(one - other).max() > 50.0


def test_contacts_are_lighter_than_every_aperture(joint):
    """So that nobody needs to tell red from green."""
    figure = snapshots.snapshot_figure(joint, "a joint")
    apertures, contacts = figure.axes[0].images
    colours = apertures.cmap(np.linspace(0.0, 1.0, 100))
    assert lightness(contacts.cmap(1.0)) > 20.0 + max(map(lightness, colours))


def lightness(colour):
    """CIE lightness L* of a colour (red, green, blue, alpha) of sRGB."""
    parts = np.asarray(colour[:3])
    linear = np.where(parts <= 0.04045, parts / 12.92, ((parts + 0.055) / 1.055) ** 2.4)
    luminance = linear @ [0.2126, 0.7152, 0.0722]
    return 116.0 * np.cbrt(luminance) - 16.0 if luminance > 0.008856 else 903.3 * luminance


@pytest.mark.parametrize("ends", [(-100.0, 1000.0), (-100.0, 40.0), (-3.0, 900.0), (-43.0, 43.0)])
def test_long_axes_of_percentages_say_that_they_are_logarithmic_with_ticks_apart(ends):
    _, axes = subplots(figsize=(3.0, 2.2))
    assert percent_ticks(axes.xaxis, 5.0, *ends) == ", logarithmic beyond ±5"
    ticks = axes.get_xticks()
    assert ticks[0] >= ends[0]
    assert ticks[-1] <= ends[1]
    assert {0.0, 5.0} <= set(ticks)
    assert ticks.size >= 3
    places = axes.transData.transform([(tick, 0.0) for tick in ticks])[:, 0]
    assert np.diff(places).min() > 0.04 * axes.bbox.width
    decades = {value for value in (100.0, 1000.0) if value <= ends[1]}
    assert decades <= set(ticks)


@pytest.mark.parametrize("width", [2.2, 1.7])
def test_narrow_axes_of_percentages_have_each_power_of_ten(width):
    _, axes = subplots(figsize=(width, 2.0))
    percent_ticks(axes.xaxis, 10.0, -160.0, 160.0, narrow=True)
    assert {-100.0, -10.0, 0.0, 10.0, 100.0} <= set(axes.get_xticks())


def test_short_axes_of_percentages_are_linear():
    _, axes = subplots(figsize=(3.0, 2.2))
    assert percent_ticks(axes.yaxis, 5.0, -12.0, 15.0) == ""
    assert axes.get_yscale() == "linear"
    assert axes.get_ylim() == (-12.0, 15.0)


@pytest.fixture(scope="module")
def flowing(walls):
    return jc.simulate(
        *walls, spacing=SPACING, rock=DOLERITE, max_normal_stress=5e6, seating_stress=0.5e6,
        flow=True,
    )  # fmt: skip


@pytest.mark.parametrize("draw", [engineering_figure, closure_curve])
def test_one_legend_below_the_panels_names_an_unloading_that_its_loading_hides(flowing, draw):
    figure = draw(flowing, "a joint")
    assert not any(axes.get_legend() for axes in figure.axes)
    (legend,) = figure.legends
    named = [text.get_text() for text in legend.get_texts()]
    assert len(set(named)) == len(named)
    assert "cycle 2, unloading (same as loading)" in named
    assert "cycle 1, unloading" in named


@pytest.mark.parametrize("blocked", [False, True])
def test_bands_of_transmissivity_end_where_joints_of_the_range_are_blocked(flowing, blocked):
    curves = stress_table(flowing)
    for name in [column for column in CURVES if column in curves]:
        curves[f"{name}_low"] = 0.9 * curves[name]
        curves[f"{name}_high"] = 1.1 * curves[name]
    low = "transmissivity_m2_per_s_low"
    curves.loc[curves.normal_stress_MPa > 2.0, low] *= 0.0 if blocked else 1.0
    figure = engineering_figure(flowing, "a joint", curves)
    band = figure.axes[3].collections[0].get_paths()[0].vertices
    assert (band[:, 0].max() <= 2.0) == blocked
    said = "some joints of the range are blocked" in figure.legends[0].get_title().get_text()
    assert said == blocked


def test_the_axis_of_transmissivity_ends_where_the_data_do(flowing):
    axes = engineering_figure(flowing, "a joint").axes[3]
    curves = stress_table(flowing)
    known = curves.transmissivity_m2_per_s[curves.transmissivity_m2_per_s > 0.0]
    low, high = axes.get_ylim()
    assert 0.5 * known.min() < low < known.min()
    assert known.max() < high < 2.0 * curves.largest_transmissivity_m2_per_s.max()


def test_the_needed_correlation_of_an_orientation_is_named_on_its_axis():
    upper, lower = jc.wall_pair(10.0, (32, 32), SPACING, 3, mismatch_wavelength=1e-3)
    scans = [Scan(wall, (SPACING, SPACING)) for wall in (-upper, lower)]
    pair = registered(*scans, orientation="common_frame", spikes="keep", unusual_values=True)
    figure = pair_figure(pair, "a pair")
    assert any("needed to be clear" in axes.get_xlabel() for axes in figure.axes)


def test_holes_of_scans_are_seen_and_named():
    upper, lower = jc.wall_pair(10.0, (32, 32), SPACING, 3, mismatch_wavelength=1e-3)
    upper[4:9, 6:12] = np.nan
    scans = [Scan(wall, (SPACING, SPACING)) for wall in (-upper, lower)]
    pair = registered(*scans, orientation="common_frame", spikes="keep", unusual_values=True)
    assert pair.holes.any()
    figure = pair_figure(pair, "a pair")
    for axes in figure.axes[:3]:
        (image,) = axes.images
        np.testing.assert_array_equal(np.ma.getmaskarray(image.get_array()), pair.holes)
        assert axes.get_facecolor() == to_rgba(HOLES)
    (legend,) = figure.legends
    assert "hole of a scan" in legend.get_texts()[0].get_text()
    whole = pair._replace(holes=np.zeros_like(pair.holes))
    assert not pair_figure(whole, "a pair").legends

"""The scale effect: how readings of nested patches go with their size."""

import numpy as np
import pytest
import xarray as xr

from jointclosure.joint.laws import barton_bandis
from jointclosure.walls.jrc import rms_slope, z2_of_jrc
from studies.size import study as scale
from tests.studied import study_of, tiny

TINY = tiny("size")
BASE = (3e-3, 0.25e-3)
ROLL_OFFS = {"flat": 1.5e-3, "free": None}


def walls_of(patch, spacing, position=0):
    """Return the walls of the first realisation of a patch [m] at a spacing [m] and a position."""
    points = scale.EXPERIMENT.jobs(study_of(TINY))["slate.free"]
    sizes = [(point.coordinates["patch"], point.coordinates["spacing"]) for point in points]
    return next(points[sizes.index((patch, spacing)) + position].walls())


@pytest.fixture(scope="module")
def run(joints):
    return scale.runs_of(joints, list(ROLL_OFFS))["slate"]


@pytest.fixture(scope="module")
def whole_walls():
    return walls_of(6e-3, 0.25e-3)


def test_walls_of_the_largest_patch_have_the_slope_of_their_jrc(whole_walls):
    for wall in whole_walls:
        assert wall.shape == (24, 24)
        # at the spacing of the study, but for their plane
        assert rms_slope(wall, 0.25e-3) == pytest.approx(z2_of_jrc(6.5, 0.25e-3, 0.6), rel=0.01)


def test_patches_and_coarser_grids_are_parts_of_the_same_walls(whole_walls):
    fine, coarse = (walls_of(1.5e-3, spacing, 1)[0] for spacing in (0.125e-3, 0.25e-3))
    assert (fine.shape, coarse.shape) == ((12, 12), (6, 6))
    of_whole = whole_walls[0][6:12, 6:12]
    # but for their planes they are the same heights
    for other in (fine[::2, ::2], of_whole):
        assert max(np.ptp(np.diff(other - coarse, axis=axis)) for axis in (0, 1)) < 1e-12
    assert np.ptp(coarse - (of_whole - of_whole.mean())) > 0.0


def test_ratios_are_of_pairs_of_the_same_walls(run):
    table = scale.size_table({"slate": run}, BASE)
    row = table.query("spectrum == 'free' and patch_mm == 6 and cycle == 1").iloc[0]
    closure = run.max_closure.sel(spectrum="free", cycle=1, spacing=0.25e-3)
    means = np.log(closure).mean("position")
    pairs = (means.sel(patch=6e-3) - means.sel(patch=3e-3)).values
    ratio = np.exp(pairs.mean())
    assert row.max_closure_mm_ratio == pytest.approx(ratio)
    assert row.max_closure_mm_error == pytest.approx(ratio * pairs.std(ddof=1) / 2.0)
    base = table[(table.patch_mm == 3) & (table.spacing_mm == 0.25)]
    assert (base.max_closure_mm_ratio == 1.0).all()
    assert (base.max_closure_mm_error == 0.0).all()


def power_law(power, bend=0.0, surfaces=6):
    """Return joints whose quantities are a power of the patch, which may be bent, with scatter."""
    random = np.random.default_rng(3)
    patch = np.array([1e-3, 2e-3, 4e-3])
    spacing = np.array([1e-4, 2e-4])
    over = ("spectrum", "patch", "spacing", "position", "realization")
    own = np.exp(0.3 * random.standard_normal((1, 1, 1, 1, surfaces)))
    size = np.log(patch / patch[0])[None, :, None, None, None]
    scatter = np.exp(1e-3 * random.standard_normal((2, 3, 2, 1, surfaces)))
    values = 1e-4 * own * scatter * np.exp(power * size + bend * size**2)
    geometry = {name: (over, 1e-4 * np.exp(0.5 * size) * scatter) for name in scale.GEOMETRY}
    readings = {name: ((*over, "cycle"), np.stack([values, values], -1)) for name in scale.READ}
    return xr.Dataset(
        readings | geometry | {"status": (over, 0.0 * values)},
        coords={"spectrum": list(ROLL_OFFS), "patch": patch, "spacing": spacing, "cycle": [1, 2]},
    )


def exponents_of(bend):
    """Exponents of closures over the patch, which go as powers, bent or not."""
    table = scale.exponent_table({"rock": power_law(0.7, bend=bend)}, (2e-3, 2e-4))
    return table[(table.reading == "max_closure") & (table.of == "patch")]


def test_an_exponent_is_found():
    straight = exponents_of(0.0)
    assert straight.exponent.values == pytest.approx(0.7, abs=4 * straight.error.max())
    assert (straight.error < 0.01).all()
    assert (straight.p > 1e-3).all()


def test_what_is_no_power_is_noticed():
    bent = exponents_of(0.1)
    # the slope of size^2 between neighbours rises by 2 ln 2 times the bend
    assert bent.change.values == pytest.approx(0.2 * np.log(2.0), abs=0.01)
    assert (bent.p < 1e-3).all()


@pytest.fixture(scope="module", params=["sizes", "sizes and spectra"])
def collapse(request):
    """What each scaling leaves of a power law between sizes, or between spectra too."""
    table = scale.collapse_table({"rock": power_law(0.7)}, ROLL_OFFS)
    table = table.query("reading == 'max_closure' and cycle == 1")
    return table.set_index(["between", "scaling"]).loc[request.param]


def test_the_right_scaling_removes_the_spread(collapse):
    assert collapse.loc["none", "removed_percent"] == 0.0
    assert collapse.loc["spacing", "removed_percent"] < 5.0
    for scaling in ("patch length", "rms height"):
        assert collapse.loc[scaling, "removed_percent"] > 99.0
    # closure goes as (rms height)^(0.7/0.5)
    assert collapse.loc["rms height", "exponents"].startswith("rms_height 1.4")


def test_the_right_scaling_carries_over_to_the_largest_patch(collapse):
    for scaling in ("patch length", "rms height"):
        assert collapse.loc[scaling, "largest_off_percent"] < 0.3
    unscaled = collapse.loc["none", "largest_off_percent"]
    assert unscaled == pytest.approx(70.0 * np.log(2), abs=0.3)


@pytest.fixture(scope="module")
def laws(run):
    """The table of Barton and Bandis' law, from 0.5 MPa, and the laws of both lengths."""
    rock = (6.5, 159e6, 5e6)
    table = scale.barton_bandis_table({"slate": run}, BASE, {"slate": rock}, 1.5, 0.5e6)
    small = barton_bandis(6.5, 159e6, 1.5, 1).since(0.5e6)
    large = barton_bandis(6.5 * 4.0**-0.13, 159e6, 1.5 * 4.0**0.195, 1).since(0.5e6)
    return table[(table.to_mm == 6) & (table.cycle == 1)].set_index("reading"), small, large


def test_the_barton_bandis_law_of_a_longer_joint_is_softer(laws):
    table, small, large = laws
    ratio = table.barton_bandis["kni_net"].iloc[0]
    assert ratio == pytest.approx(large.initial_stiffness / small.initial_stiffness)
    assert 0.0 < ratio < 1.0


def test_closures_of_the_barton_bandis_law_count_from_seating_as_those_of_the_model(laws):
    table, small, large = laws
    ratio = table.barton_bandis["max_closure_seated_net"].iloc[0]
    assert ratio == pytest.approx(float(large.closure(4.5e6) / small.closure(4.5e6)))


def test_the_barton_bandis_law_has_all_results_of_the_model(laws):
    readings = {"kni_net", "vm_net", "stiffness_net", "max_closure_seated_net"}
    assert set(laws[0].index) == readings


def test_what_is_too_many_cells_is_not_closed(run):
    sizes = [(1.5e-3, 0.125e-3), (1.5e-3, 0.25e-3), (3e-3, 0.25e-3), (6e-3, 0.25e-3)]
    assert list(scale.sizes_of(study_of(TINY).size, 0.25e-3)) == sizes
    closed = np.isfinite(run.status).sum("position").isel(spectrum=0, realization=0)
    assert closed.values.tolist() == [[4, 4], [0, 2], [0, 1]]


# Powers are found, and what they remove is judged by surfaces that were not fitted


def made_up(surfaces, noise, power=0.7, extra=0.0, seed=1):
    """Return predictor and response of many surfaces: a power of a size, and an ``extra`` part."""
    random = np.random.default_rng(seed)
    size = np.log(np.repeat([1.0, 2.0, 4.0], 3))
    other = np.tile([-1.0, 2.0, -1.0], 3)
    own = random.standard_normal(surfaces)  # what a surface has at all conditions
    scatter = noise * random.standard_normal((9, surfaces))
    response = (power * size + extra * other)[:, None] + own + scatter
    predictor = np.broadcast_to(size[:, None], response.shape)[np.newaxis]
    return [scale.centred(values, np.zeros(9)) for values in (predictor, response)]


def test_a_size_that_means_nothing_removes_nothing_of_surfaces_not_fitted():
    removed = []
    for seed in range(40):
        random = np.random.default_rng(100 + seed)
        predictors, response = made_up(8, 0.05, power=0.0, extra=0.1, seed=seed)
        noise = scale.centred(random.standard_normal((5, *response.shape)), np.zeros(9))
        before, after = scale.spreads(np.concatenate([predictors, noise]), response)
        removed.append(1.0 - after / before)
    mean = np.mean(removed)
    error = np.std(removed) / np.sqrt(len(removed))
    assert -0.2 < mean < 2.0 * error


def test_errors_of_the_exponent_cover_it():
    found = [scale.collapse_of(*made_up(8, 0.2, seed=seed)) for seed in range(60)]
    held = [abs(one.exponents[0] - 0.7) < 2.36 * one.errors[0] for one in found]  # t of 7 degrees
    assert np.mean(held) > 0.85


def test_the_spread_is_free_of_the_noise_of_its_means():
    squares = [scale.spreads(*made_up(8, 0.5, power=0.3, seed=seed))[0] for seed in range(200)]
    true = np.mean((0.3 * np.log([0.5, 1.0, 2.0])) ** 2)
    error = np.std(squares) / np.sqrt(len(squares))
    assert abs(np.mean(squares) - true) < 3.0 * error
    assert true > 3.0 * error


def test_nothing_is_told_of_scalings_by_few_surfaces_or_of_what_is_not_above_zero():
    for surfaces, told in ((5, False), (6, True)):
        run = power_law(0.7, surfaces=surfaces)
        joints = scale.stack_conditions(run, ROLL_OFFS, "max_closure", 1)
        row = scale._row(joints, np.zeros(joints.sizes["condition"]), ("patch",))
        assert row["realizations"] == surfaces
        assert np.isfinite([row[name] for name in scale.NUMBERS]).all() == told
    run["max_closure"][0, 0, 0, 0, :2, 0] = np.array([0.0, -1e-4])
    logs = scale.mean_logs(run, "max_closure", 1)
    assert np.isnan(logs[0, 0, 0, :2]).all()
    assert np.isfinite(logs[0, 0, 0, 2:]).all()
    one = np.array([0.1, np.nan])
    assert np.isnan(scale._ratio(one, np.zeros(2))).all()

"""Properties and open choices that vary together: their design, and the shares of each."""

import numpy as np
import pytest
import xarray as xr

from jointclosure.inputs import InputError
from jointclosure.parameters.units import to_si
from studies.frame.cases import base_case, block_settings
from studies.frame.configuration import configured, merged
from studies.frame.joint_tables import as_table
from studies.frame.simulation import close_points
from studies.frame.yaml_files import read_plain
from studies.global_sensitivity import tables as sensitivity
from studies.global_sensitivity.design import keys_at, sampling_of, settings_of_rock
from tests.studied import ROOT, study_of, tiny

ELASTICITIES = {"youngs_modulus": -0.9, "compressive_strength": 0.5, "jrc": 0.3}
OVER = ("row", "point", "surface", "cycle")


@pytest.fixture(scope="module")
def design():
    rows = {"global_sensitivity": {"rows": 64}}  # beyond the file's 16
    return sampling_of(study_of(tiny("global_sensitivity"), rows))


@pytest.fixture(scope="module")
def world(design):
    """Closures that are powers of the properties with noise, twice as large for current peaks."""
    closed = {}
    for rock in design.rocks:
        points = design.points()
        random = np.random.default_rng(3)
        own = np.empty(points.shape[:2])
        for where in np.ndindex(own.shape):
            at = keys_at(design, rock, points[where])
            values = to_si(at["rocks"][rock])
            own[where] = np.prod([values[name] ** power for name, power in ELASTICITIES.items()])
            own[where] *= 2.0 if at["choices"]["peaks"] == "current" else 1.0
        noise = 1.0 + 0.05 * random.standard_normal((len(points), 1, 2, 1))
        values = own[:, :, None, None] * noise * np.ones(2)
        parts = {name: (OVER, values.copy()) for name in sensitivity.RESPONSES_AND_LOOP}
        parts["loop"] = OVER, values * [0.5, 0.0]
        closed[rock] = xr.Dataset(parts, {"row": np.arange(len(points)), "cycle": [1, 2]})
    return closed


def test_an_input_lies_between_its_ends_as_its_point_says(design):
    point = design.points()[3, 0]
    keys = keys_at(design, "slate", point)
    modulus = 60.0 + (72.0 - 60.0) * point[1]  # Table 2
    assert keys["rocks"]["slate"]["youngs_modulus_GPa"] == pytest.approx(modulus)
    assert keys["choices"]["peaks"] == ("pristine" if point[4] < 0.5 else "current")


MORE = {
    "effect": {"key": "effects.gouge", "values": [True, False]},
    "of_rock": {"key": "rocks.ROCK.effects.soft_peaks", "values": [True, False]},
    "auto": {"key": "effects.auto", "values": [None, 0.02]},
    "step": {"key": "numerics.displacement_step_um", "between": [6, 12]},
}


def test_fields_that_are_replaced_make_the_settings_that_the_same_keys_make():
    inputs = {name: each | {"title": name} for name, each in MORE.items()}
    file = ROOT / "studies/global_sensitivity/global_sensitivity_full.yaml"
    full = study_of(read_plain(file), {"global_sensitivity": {"inputs": inputs}})
    sampling = sampling_of(full)
    for rock in sampling.rocks:
        settings = settings_of_rock(sampling, full, rock)
        for row, point in enumerate(sampling.points()[:3, 0]):
            alone = {"study": {"rocks": [rock], "draws": "common"}}
            typed = configured(merged(full.stated, keys_at(sampling, rock, point), alone))
            block = range(2 * row, 2 * row + 2)
            expected = block_settings(typed, base_case(typed, rock), block)
            assert repr(settings(row, point)) == repr(expected)


def test_elasticities_are_those_of_the_closures_whatever_the_choices(world, design):
    table = sensitivity.global_elasticity_table(design, world)
    for row in table.itertuples():
        truth = ELASTICITIES.get(row.input, 0.0)
        # surfaces are noise of a row, which changes within a row do not have
        assert row.elasticity == pytest.approx(truth, abs=1e-3)
        assert row.spread < 1e-3
    sure = table[table.input.isin(ELASTICITIES) & (table.elasticity.abs() > 0.1)]
    assert (sure.share_positive == (sure.elasticity > 0.0)).all()


def test_the_choice_that_doubles_the_closure_has_most_of_its_variance(world, design):
    table = sensitivity.index_table(design, world)
    whole = table[(table.rows == 64) & (table.response == "max_closure")]
    assert (whole[whole.input == "peaks"].total > 0.8).all()
    nothing = whole[whole.input == "poisson_ratio"]
    assert (nothing.total.abs() <= 3.0 * nothing.total_error + 1e-9).all()
    assert sorted(table.rows.unique()) == [16, 32, 64]
    inputs = whole[(whole.input != "surfaces") & (whole.cycle == 1) & (whole.rock == "slate")]
    np.testing.assert_allclose(inputs[["shapley", "shapley_dependent"]].sum(), 1.0, rtol=1e-6)


def test_conclusions_hold_for_the_share_of_choices_for_which_they_are_true(world, design):
    table, margins = sensitivity.conclusion_tables(design, world)
    assert set(table.rock) == {"dolerite", "slate", "all"}
    for number in ("1a", "2a", "3", "5a", "5b", "5c"):
        assert (table[table.number == number].share > 0.95).all(), number
        assert (table[table.number == number].rows_true == 64).all(), number
    assert set(table[table.number == "4"].cycle) == {2}
    assert (table[table.number == "1b"].share == 1.0).all()  # no closure depends on it
    loops = table[table.number == "6a"]
    assert set(zip(loops.cycle, loops.rock, loops.share, strict=True)) == {
        (cycle, rock, 2.0 - cycle) for cycle in (1, 2) for rock in ("dolerite", "slate", "all")
    }
    small = {name: each.assign(loop=0.01 * each.max_closure) for name, each in world.items()}
    unseen = sensitivity.conclusion_tables(design, small)[0]
    assert (unseen[unseen.number == "6a"].share == 0.0).all()  # a loop of 1 % is none
    assert table.share_low.between(0.0, table.share).all()
    assert table.share_high.between(table.share, 1.0).all()
    assert set(margins.input) == set(design.inputs)
    # a share is not known closer than its rows tell: Wilson's 95 % interval of 64 that all agree
    sure = table[(table.number == "5a") & (table.rock == "all")]
    assert (sure.share_error == 0.0).all()
    np.testing.assert_allclose(sure.share_low, 64 / (64 + 1.96**2), rtol=1e-4)
    assert (sure.share_high == 1.0).all()
    switched = {n: each.assign(max_closure=1.0 / each.max_closure) for n, each in world.items()}
    shares = sensitivity.conclusion_tables(design, switched)[0]
    shares = shares[shares.response == "max_closure"].set_index("number").share
    assert (shares[["5a", "5b", "5c"]] < 0.05).all()
    with pytest.raises(InputError, match="the joints of slate are missing"):
        sensitivity.conclusion_tables(design, {"dolerite": world["dolerite"]})


def mixed(world, design, part: float) -> dict:
    """Return closures that also go as E^3 at a part of the points, other ones in each rock."""
    changed = {name: each.copy(deep=True) for name, each in world.items()}
    points = design.points()
    for rock, at in (("dolerite", 0.0), ("slate", 1.0 - part)):
        here = (points[:, :, 0] >= at) & (points[:, :, 0] < at + part)
        low, high = (78e9 - 8e9, 78e9 + 7e9) if rock == "dolerite" else (60e9, 72e9)
        modulus = low + (high - low) * points[:, :, 1]
        factor = np.where(here, (modulus / low) ** 3, 1.0)[:, :, None, None]
        changed[rock]["max_closure"] = changed[rock].max_closure * factor
    return changed


def test_a_regression_that_misses_a_change_leaves_more_than_noise(world, design):
    random = np.random.default_rng(5)
    noise = np.exp(0.01 * random.standard_normal(world["slate"].max_closure.shape))
    noisy = {n: each.assign(max_closure=noise * each.max_closure) for n, each in world.items()}
    fits = sensitivity.global_elasticity_table(design, noisy)
    fits = fits[fits.response == "max_closure"]
    assert fits.fit_over_noise.between(0.4, 2.0).all()
    missed = sensitivity.global_elasticity_table(design, mixed(noisy, design, 0.5))
    of_modulus = missed[(missed.response == "max_closure") & (missed.input == "youngs_modulus")]
    assert (of_modulus.fit_over_noise > 2.0).all()


@pytest.fixture(scope="module")
def with_failures(design, world):
    """Indices of a world with one failed simulation, and few rows of a rock's net closure."""
    broken = {name: each.copy(deep=True) for name, each in world.items()}
    for each in broken.values():
        each.max_closure[5, 2, 0, :] = np.nan
    broken["dolerite"].max_closure_net[5:, 2, 0, :] = np.nan
    return sensitivity.index_table(design, broken)


def test_a_row_with_a_failed_simulation_is_left_out(with_failures):
    table = with_failures
    whole = table[(table.response == "max_closure") & (table.rows > 32)]
    assert (set(whole.rows), set(whole.left_out)) == ({63}, {1})
    assert whole.total.notna().all()


def test_few_rows_that_are_left_have_no_indices(with_failures, design):
    table = with_failures
    here = table[(table.rows == 64) & (table.cycle == 1)]
    assert (here.groupby(["rock", "response"]).size() == len(design.inputs) + 1).all()
    of_rocks = (set(here[here.rock == rock].response) for rock in ("slate", "dolerite"))
    assert set.difference(*of_rocks) == {"max_closure_net"}


@pytest.fixture(scope="module")
def of_one_row(jobs):
    """Joints of the points of a row as a table, and on a grid."""
    points = [point for point in jobs["slate.0"] if point.coordinates["row"] == 2]
    joints = as_table([close_points(points, sensitivity.RESPONSES_AND_LOOP)])
    return joints, sensitivity.datasets_by_rock(joints)["slate"]


def test_joints_of_points_are_put_on_a_grid(of_one_row):
    joints, closed = of_one_row
    assert dict(closed.sizes) == {"row": 1, "point": 7, "surface": 2, "cycle": 2}
    second = closed.max_closure.sel(row=2, cycle=2)
    for row in joints[joints.cycle == 2].itertuples():
        assert second.sel(point=row.point, surface=row.realization - 4) == row.max_closure


def test_joints_of_points_are_read(of_one_row):
    _, closed = of_one_row
    assert (closed.status < 16).all()
    assert (closed.max_closure_net < closed.max_closure).all()
    # of these small joints some begin to land on the maximum below half of it: no first stiffness
    read = closed.compliance_net > 0.0
    assert read.sel(cycle=2).mean() > 0.8
    assert read.sel(cycle=1).any()
    assert (read | np.isnan(closed.compliance_net)).all()


def test_a_margin_goes_with_the_input_that_turns_the_conclusion(world, design):
    margins = sensitivity.conclusion_tables(design, mixed(world, design, 0.5))[1]
    here = margins[(margins.number == "5a") & (margins.response == "max_closure")]
    assert (here[here.input == "poisson_ratio"].share > 0.9).all()
    assert (here[here.input != "poisson_ratio"].share < 0.1).all()

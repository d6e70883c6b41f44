"""Joints of mated, natural and non-mated walls, and the shift that unmates them."""

import numpy as np
import pandas as pd
import pytest

from studies.frame.joint_tables import gridded
from studies.mismatch.study import EXPERIMENT, MEANS, find_independence, tabulate_mismatch

CRITERION = {"tolerance": 0.1, "root_seed": 1}


@pytest.fixture(scope="module")
def run(joints):
    """Joints over (wavelength, shift, realization, cycle)."""
    return gridded(joints, ("wavelength", "shift", "realization"), EXPERIMENT.quantities)


@pytest.fixture(scope="module")
def first_closures(run):
    return run.sel(cycle=1).mean("realization").max_closure_seated_net


def test_walls_close_more_the_longer_the_mismatch(first_closures):
    still = first_closures.sel(shift=0.0).values
    assert still.tolist() == sorted(still)
    assert still[-1] > 1.5 * still[0]


def test_shifted_walls_close_more_than_unshifted_ones(first_closures):
    moved = first_closures.sel(wavelength=1e-3).values
    assert moved[1] > 1.2 * moved[0]


def test_means_are_those_of_the_joints(tables, run):
    table = tables["mismatch"]
    own = run.sel(wavelength=1e-3, shift=0.0, cycle=2)
    row = table[(table.wavelength_mm == 1.0) & (table.shift_mm == 0.0) & (table.cycle == 2)]
    assert row.samples.item() == 3
    closure = 1e3 * float(own.max_closure_seated_net.mean())
    assert row.max_closure_seated_net_mm.item() == pytest.approx(closure)
    stays = float(own.residual_closure_seated_net.mean() / own.max_closure_seated_net.mean())
    assert row.residual_share_net.item() == pytest.approx(stays)
    assert len(table) == 2 * (2 * 2 + 1)  # independent walls are not shifted


def made_up(closures, scatter, surfaces=40):
    """Return joints with given mean closures [0.1 mm]: of independent walls, then over shifts."""
    rng = np.random.default_rng(2)
    drawn = 1e-4 * (1.0 + scatter * rng.standard_normal((2, len(closures) - 1, surfaces)))
    free, *shifted = closures
    conditions = [(np.inf, 0.0, free * drawn[1, 0])]
    conditions += [
        (1e-3, 1e-3 * place, factor * drawn[0, place]) for place, factor in enumerate(shifted)
    ]
    known = {"rock": "slate", "cycle": 1, "mean_aperture_at_seating": 5e-4}
    return pd.concat(
        pd.DataFrame(
            known | {"wavelength": wavelength, "shift": shift, "max_closure_seated_net": values}
        )
        for wavelength, shift, values in conditions
    )


def test_the_shift_that_unmates_is_between_those_about_the_criterion():
    run = made_up([1.0, 0.5, 0.8, 1.0], 1e-9)
    (row,) = find_independence(run, CRITERION).itertuples()
    assert row.shift_mm == pytest.approx(1.5)
    assert row.low == pytest.approx(row.high)
    # in mean apertures of independent walls, 0.5 mm
    assert row.apertures == pytest.approx(3.0)
    never = made_up([1.0, 0.5, 0.6, 0.7], 1e-9)
    assert find_independence(never, CRITERION).shift_mm.item() == np.inf


def test_the_interval_of_that_shift_covers_it():
    held = []
    for factor in np.linspace(0.97, 1.03, 9):
        run = made_up([1.0, 0.5, 0.8 * factor, 1.1], 0.15)
        (row,) = find_independence(run, CRITERION).itertuples()
        true = 1.0 + (0.9 - 0.8 * factor) / (1.1 - 0.8 * factor)
        held.append(row.low <= true <= row.high)
        assert row.low < row.shift_mm < row.high
    assert np.mean(held) >= 0.75


def shift_of(closures):
    """Shift [mm] that makes walls of given mean closures independent."""
    (row,) = find_independence(
        made_up(closures, 1e-9), {"tolerance": 0.1, "root_seed": 1}
    ).itertuples()
    return row.shift_mm


def test_walls_that_close_enough_without_a_shift_need_none():
    assert shift_of([1.0, 0.95, 1.0, 1.0]) == pytest.approx(0.0, rel=1e-6, abs=1e-6)


@pytest.mark.parametrize(
    ("closures", "shift"),
    [
        ([1.0, 0.5, 0.96, 0.8], np.inf),  # isotonic: 0.88 from the second shift on
        ([1.0, 0.5, 0.96, 0.92], 1.0 - 0.04 / 0.44),
    ],
)
def test_means_that_are_close_enough_do_not_fall_with_the_shift(closures, shift):
    assert shift_of(closures) == pytest.approx(shift, rel=1e-6, abs=1e-6)


def test_the_ends_of_that_shift_leave_out_a_fortieth_of_the_resamples_each():
    """Nearly normal: linear between shifts, of means of many surfaces."""
    run = made_up([1.0, 0.5, 0.7, 1.1], 0.1, surfaces=400)
    (row,) = find_independence(run, {"tolerance": 0.1, "root_seed": 1}).itertuples()
    error = 0.1 / np.sqrt(400) / 0.4  # of the level, and of the means at both shifts
    share = (0.9 - 0.7) / 0.4
    of_mean = np.hypot(0.7 * (1.0 - share), 1.1 * share)
    half = 1.96 * error * np.hypot(of_mean, 0.9)
    assert row.high - row.low == pytest.approx(2.0 * half, rel=0.12)


def test_joints_that_failed_are_in_no_mean():
    about = {"rock": "slate", "wavelength": 1e-3, "shift": 0.0, "cycle": 1}
    values = {name: [1e-4, 3e-4, np.nan] for name in (*MEANS, "stiffness_net")}
    joints = pd.DataFrame(about | values | {"status": [0, 0, 16]})
    (row,) = tabulate_mismatch(joints, {}).itertuples()
    assert row.samples == 2
    assert row.max_closure_mm == pytest.approx(0.2)
    assert row.max_closure_mm_error == pytest.approx(0.1)

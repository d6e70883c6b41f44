"""Many joints closed without a workflow."""

import functools
import inspect
import threading

import numpy as np
import pytest
import xarray as xr

import jointclosure as jc
from jointclosure.ensembles import simulation
from jointclosure.ensembles.simulation import NOT_SIMULATED
from jointclosure.execution.workers import in_threads
from jointclosure.joint import warmup
from jointclosure.joint.conditions import Conditions
from jointclosure.joint.status import FAILURE
from jointclosure.parameters import scene_name
from jointclosure.uncertainty import expected_cost as estimation
from jointclosure.uncertainty.expected_cost import (
    BYTES,
    EXPONENTS,
    SMALL,
    Cost,
    expected_cost,
)
from jointclosure.uncertainty.uncertain_joint import UncertainJoint, uncertain_joint
from jointclosure.walls.joint_grid import coarser_grid
from tests.ensembles.dying import kill_worker_once
from tests.joints import DOLERITE, SPACING
from tests.processes import python

LOAD = {"spacing": SPACING, "rock": DOLERITE, "max_normal_stress": 2e6, "seating_stress": 0.2e6}


def rule(seed):
    return jc.wall_pair(8.0, (12, 16), SPACING, seed)


@pytest.fixture(scope="module")
def alone():
    return jc.simulate_ensemble(rule, seeds=[3, 5, 4], workers=1, **LOAD)


def without_times(ensemble):
    return ensemble.drop_vars("timing_simulation")


def test_a_joint_that_cannot_be_closed_loses_no_other(alone):
    pairs = [rule(seed) for seed in (3, 5, 4)]
    pairs[1] = (pairs[1][0], np.full((12, 16), np.nan))
    with pytest.warns(UserWarning, match=r"1 of 3 joints .* seeds \[1\]"):
        ensemble = jc.simulate_ensemble(pairs, workers=1, **LOAD)
    assert ensemble.status.values[1] == NOT_SIMULATED >= FAILURE
    assert "lower: 192 values are not finite" in ensemble.error.values[1]
    assert np.isnan(ensemble.closure.values[1]).all()
    for place in (0, 2):
        assert ensemble.error.values[place] == ""
        np.testing.assert_array_equal(ensemble.closure.values[place], alone.closure.values[place])


@pytest.mark.parametrize("shipped", [False, True])
def test_kernels_that_are_not_shipped_are_compiled_before_several_processes(shipped, monkeypatch):
    calls = []
    share = simulation.in_processes
    monkeypatch.setattr(warmup, "all_are_shipped", lambda: shipped)
    monkeypatch.setattr(warmup, "compile_kernels", lambda *kernel: calls.append(kernel))
    monkeypatch.setattr(
        simulation, "in_processes", lambda *task: calls.append("shared") or share(*task)
    )
    jc.simulate_ensemble(rule, seeds=[3, 5], workers=2, **LOAD)
    kernels = (scene_name(jc.Effects()), "pristine", "base", "fast", "fixed_step")
    assert calls == (["shared"] if shipped else [kernels, "shared"])


def test_shipped_kernels_are_loaded_where_this_process_simulates(monkeypatch):
    loaded = []
    monkeypatch.setattr(warmup, "all_are_shipped", lambda: True)
    monkeypatch.setattr(warmup, "compile_kernels", lambda *kernel: loaded.append(kernel))
    warmup.prepare_kernels([jc.Conditions(**LOAD).model], workers=1)
    assert len(loaded) == 1


def test_a_model_whose_kernels_are_not_shipped_is_compiled(monkeypatch):
    compiled = []
    monkeypatch.setattr(warmup, "all_are_shipped", lambda: True)
    monkeypatch.setattr(warmup, "compile_kernels", lambda *kernel: compiled.append(kernel))
    effects, choices, numerics = jc.Conditions(**LOAD).model
    unbounded = choices._replace(strength_bound="none"), numerics._replace(solver="reference")
    warmup.prepare_kernels([(effects, *unbounded)], workers=2)
    assert [kernel[2:4] for kernel in compiled] == [("none", "reference")]


def test_every_function_that_closes_joints_takes_the_same_conditions(alone):
    conditions = jc.Conditions(**LOAD | {"max_normal_stress": 1e6, "unusual_values": True})
    same = jc.simulate_ensemble(
        rule, seeds=[3, 5, 4], workers=1, conditions=conditions, max_normal_stress=2e6
    )
    xr.testing.assert_identical(without_times(same), without_times(alone))
    one = jc.simulate(*rule(3), conditions=conditions, max_normal_stress=2e6)
    np.testing.assert_array_equal(one.max_closure, alone.max_closure[0])
    for function in (jc.simulate, jc.simulate_ensemble, jc.close, jc.choose_effects):
        assert {*jc.Conditions._fields, "conditions"} < {*inspect.signature(function).parameters}
        walls = [None] * (2 if function in (jc.simulate, jc.close) else 1)
        with pytest.raises(TypeError, match=r"normal_stress.*did you mean max_normal_stress"):
            function(*walls, **LOAD | {"normal_stress": 1e6})
        with pytest.raises(TypeError, match=r"needs the keyword arguments .*rock"):
            function(*walls, spacing=SPACING, max_normal_stress=1e6)


def test_where_none_can_be_closed_the_reason_is_raised():
    flat = (np.zeros((2, 2)), np.zeros((2, 2)))
    with pytest.raises(jc.InputError, match="at least 3 cells"):
        jc.simulate_ensemble([flat, flat], workers=1, **LOAD)
    with pytest.raises(jc.InputError, match="there are none"):
        jc.simulate_ensemble([], **LOAD)
    with pytest.raises(jc.InputError, match="workers = 0"):
        jc.simulate_ensemble(rule, workers=0, **LOAD)


def test_threads_end_with_the_work_that_wanted_them():
    waiting, ended = threading.Barrier(2), []

    def work(task, going_on):
        waiting.wait(timeout=30.0)  # both have begun
        while task:
            try:
                going_on()
            except InterruptedError:
                return ended.append(task)
        return task

    for place, result in in_threads(work, [0, 1], 2):
        assert (place, result) == (0, 0)
        break  # as by an interruption
    assert ended == [1]


@pytest.fixture(scope="module")
def after_a_kill(tmp_path_factory):
    """Joints of which one, by two workers, was closed again after its worker was killed."""
    pairs = [rule(seed) for seed in (3, 5, 4)]
    pairs[1] = tuple(wall - pairs[1][0][0, 0] for wall in pairs[1])
    marker = tmp_path_factory.mktemp("killed") / "killed"
    killing = functools.partial(kill_worker_once, marker=marker)
    again = pytest.warns(UserWarning, match=r"simulating again: seeds \[1\]")
    with pytest.MonkeyPatch.context() as patch, again as warned:
        patch.setattr(simulation, "simulate_row", killing)
        ensemble = jc.simulate_ensemble(pairs, workers=2, **LOAD)
    assert len(warned) == 1
    assert marker.exists()
    return ensemble


def test_a_joint_whose_worker_was_killed_is_closed_again(after_a_kill):
    assert (after_a_kill.error == "").all()
    assert np.isfinite(after_a_kill.max_closure).all()


def test_the_number_of_workers_changes_no_bit(after_a_kill, alone):
    one, other = (
        without_times(each).isel(realization=[0, 2]).drop_vars("seed")
        for each in (after_a_kill, alone)
    )
    xr.testing.assert_identical(one, other)


def test_a_script_without_a_guard_is_not_run_again(tmp_path):
    """Processes of multiprocessing would run it, and start others."""
    script = tmp_path / "script.py"
    script.write_text(
        "import numpy as np, jointclosure as jc\n"
        "print('run')\n"
        "pairs = [jc.wall_pair(8.0, (8, 8), 0.25e-3, seed) for seed in range(2)]\n"
        "found = jc.simulate_ensemble(pairs, spacing=0.25e-3, rock='granite', workers=2,\n"
        "    max_normal_stress=1e6, effects=jc.Effects(False, False, False, False, False))\n"
        "print(found.sizes['realization'])\n"
    )
    assert python(script).stdout.split() == ["run", "2"]


# Cost of a large joint before it is closed


CONDITIONS = Conditions(SPACING, DOLERITE, 1e6).checked()


def walls(cells):
    return jc.wall_pair(8.0, (cells, cells), SPACING, 1, mismatch_wavelength=1e-3)


def test_small_joints_are_closed_without_an_estimate():
    assert expected_cost(uncertain_joint(*walls(32), CONDITIONS)) is None


@pytest.fixture(scope="module")
def single_cost():
    """Walls, and what it costs to close them without their range."""
    upper, lower = walls(160)
    assert upper.size > SMALL
    return upper, lower, expected_cost(UncertainJoint(upper, lower, CONDITIONS))


def test_the_cost_grows_with_the_range(single_cost):
    upper, lower, one = single_cost
    several = expected_cost(uncertain_joint(upper, lower, CONDITIONS))
    for cost in (one, several):
        assert 0.0 < cost.seconds[0] < cost.seconds[1]
    assert several.seconds[0] > 5.0 * one.seconds[0]


def test_the_cost_grows_with_the_cells(single_cost):
    upper, lower, one = single_cost
    tiled = (np.tile(wall, 2) for wall in (upper, lower))
    larger = expected_cost(UncertainJoint(*tiled, CONDITIONS))
    assert larger.memory - one.memory == BYTES * upper.size


def test_a_cost_is_stated_in_times_of_the_processor():
    text = Cost((140.0, 3900.0), 5e8).sentence((160, 160), SPACING)
    assert "160 x 160 cells will take about 2 min to 1 h of processor time and 0.5 GB" in text


def test_the_cost_of_a_range_is_that_of_the_cells_of_its_variants(monkeypatch):
    monkeypatch.setattr(estimation, "time_of_window", lambda *about: (1.0, 128 * 128))
    upper, lower = walls(160)
    joint = uncertain_joint(upper, lower, CONDITIONS)
    one = expected_cost(UncertainJoint(upper, lower, CONDITIONS))
    several = expected_cost(joint)
    cells = np.array([upper[:: v.step, :: v.step].size / upper.size for v in joint.variants])
    assert 0 < np.count_nonzero(cells < 1.0) < cells.size
    for power, alone, together in zip(EXPONENTS, one.seconds, several.seconds, strict=True):
        assert together / alone == pytest.approx(1.0 + (cells**power).sum())
    first, three = (expected_cost(joint, workers) for workers in (1, 3))
    assert three.memory - first.memory == 2 * BYTES * upper.size


FLAT = np.zeros((200, 200))


def forecast(monkeypatch, made=uncertain_joint, workers=None):
    """Expected cost of a flat joint, as if its window of 128 x 128 cells took ten seconds."""
    monkeypatch.setattr(estimation, "time_of_window", lambda *walls: (10.0, 128 * 128))
    return expected_cost(made(FLAT, FLAT, Conditions(**LOAD).checked()), workers)


def test_a_forecast_has_the_powers_of_the_cells_with_their_scatter(monkeypatch):
    one = forecast(monkeypatch, UncertainJoint)
    share = FLAT.size / 128**2
    assert one.seconds == pytest.approx((10.0 / 1.4 * share**1.15, 10.0 * 1.4 * share**1.75))
    ranged = forecast(monkeypatch, workers=2)
    assert ranged.seconds[0] > 10.0 * one.seconds[0]


def test_a_forecast_has_the_memory_of_all_joints_at_once(monkeypatch):
    one = forecast(monkeypatch, UncertainJoint)
    assert one.memory == pytest.approx(300e6 + 1000 * FLAT.size)
    ranged = forecast(monkeypatch, workers=2)
    assert ranged.memory == pytest.approx(300e6 + 2 * 1000 * FLAT.size)


@pytest.mark.parametrize(("cells", "step"), [((150, 200), 2), ((150, 401), 3)])
def test_a_forecast_of_many_cells_comes_with_a_coarser_spacing(cells, step):
    assert f"{1e3 * step * SPACING:.4g} mm" in coarser_grid(cells, SPACING)

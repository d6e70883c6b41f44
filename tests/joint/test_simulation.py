import itertools
import subprocess
import sys
from unittest.mock import patch

import numpy as np
import pytest
import xarray as xr

import jointclosure as jc
from jointclosure.joint.protocol import FAILURE, FLAGS
from jointclosure.joint.simulation import height_datum
from jointclosure.parameters import well_posed_scenes
from jointclosure.solvers.fast import FastSolver
from jointclosure.solvers.registry import SOLVERS
from jointclosure.storage.netcdf import read_netcdf
from tests.joints import DOLERITE, SPACING

TARGET = 4e6


@pytest.fixture(scope="module")
def walls():
    return jc.wall_pair(8.0, (24, 24), SPACING, seed=11)


@pytest.fixture(scope="module")
def closed(walls):
    return jc.simulate(
        *walls, spacing=SPACING, rock=DOLERITE, max_normal_stress=TARGET, seating_stress=5e5
    )


def on(dataset, cycle, branch):
    """Closure and stress on one branch, its start included."""
    here = np.flatnonzero((dataset.cycle.values == cycle) & (dataset.branch.values == branch))
    here = np.concatenate([here[:1] - 1, here]) if here[0] > 0 else here
    return dataset.closure.values[here], dataset.normal_stress.values[here]


def test_history_starts_at_first_touch_and_has_the_promised_variables(closed):
    assert closed.closure.values[0] == 0.0
    assert closed.normal_stress.values[0] == 0.0
    assert closed.cycle.dims == closed.branch.dims == ("step",)
    along_step = {
        "closure",
        "normal_stress",
        "contact_fraction",
        "bulk_indentation",
        "mean_aperture",
        "equilibrium_residual",
    }
    assert along_step == {name for name, v in closed.data_vars.items() if v.dims == ("step",)}
    for name in ("max_closure", "residual_closure"):
        assert closed[name].dims == closed[f"{name}_seated"].dims == ("cycle",)
    for variable in closed.data_vars.values():
        assert variable.attrs["long_name"]


def test_every_maximum_lands_on_the_target_or_says_that_it_jumped(closed):
    for cycle in (1, 2):
        stress = on(closed, cycle, "loading")[1]
        if not int(closed.status) & 1:
            assert stress[-1] == pytest.approx(TARGET, rel=1e-3)
        assert stress.max() == stress[-1]


def test_unloading_ends_exactly_at_last_contact(closed):
    for cycle in (1, 2):
        closure, stress = on(closed, cycle, "unloading")
        assert stress[-1] == 0.0
        assert stress[-2] > 0.0
        assert closed.residual_closure.values[cycle - 1] == closure[-1]
    assert closed.attrs["seating_stress_Pa"] == 5e5


def test_last_contact_is_where_the_walls_as_they_are_only_just_touch(closed, walls):
    touch = (walls[0] + walls[1]).max() - float((closed.upper_final + closed.lower_final).max())
    assert closed.residual_closure.values[-1] == pytest.approx(touch, abs=1e-18)


def test_closures_follow_the_conventions(closed):
    first, second = on(closed, 1, "loading"), on(closed, 2, "loading")
    ends = [on(closed, cycle, "unloading")[0][-1] for cycle in (1, 2)]
    expected = [first[0][-1], second[0][-1] - ends[0]]
    np.testing.assert_allclose(closed.max_closure, expected)
    np.testing.assert_allclose(closed.residual_closure, ends)
    seat = [np.interp(5e5, stress, closure) for closure, stress in (first, second)]
    np.testing.assert_allclose(
        closed.max_closure_seated, [first[0][-1] - seat[0], second[0][-1] - seat[1]], rtol=1e-6
    )


def test_unloading_lies_below_loading(closed):
    for cycle in (1, 2):
        closure, stress = on(closed, cycle, "loading")
        back, relief = on(closed, cycle, "unloading")
        inside = (back > closure[0]) & (back < closure[-1])
        assert np.all(relief[inside] <= np.interp(back[inside], closure, stress) + 1e-3 * TARGET)


def test_the_excess_of_unloading_is_reported_and_a_hundredth_of_the_stress_at_most(closed):
    assert closed.unloading_excess.dims == ("cycle",)
    assert closed.unloading_excess.attrs["units"] == "Pa"
    assert np.all(closed.unloading_excess >= 0.0)
    assert np.all(closed.unloading_excess <= 1e-2 * TARGET)


@pytest.mark.parametrize("solver", ["fast", "reference"])
def test_without_breakage_unloading_never_exceeds_loading(walls, solver):
    # the fast solver goes up and down the same points; the reference stops at a change of 1e-12
    # between sweeps, and its branches are read linearly between steps, each point on the other
    elastic = jc.simulate(
        *walls,
        spacing=SPACING,
        rock=DOLERITE,
        max_normal_stress=TARGET,
        cycles=1,
        effects=jc.Effects(breakage=False, gouge=False),
        numerics=jc.Numerics(solver=solver, sweep_tolerance=1e-12),
    )
    if solver == "fast":
        assert elastic.unloading_excess == 0.0
        return
    for closure, stress in zip(*on(elastic, 1, "unloading"), strict=True):
        state = jc.equilibrium(
            *walls,
            spacing=SPACING,
            rock=DOLERITE,
            closure=float(closure),
            effects=jc.Effects(breakage=False, gouge=False),
            numerics=jc.Numerics(force_tolerance=1e-8),
        )
        assert stress <= float(state.normal_stress) * (1.0 + 1e-7) + 1e-9


def test_seating_changes_the_reading_and_never_the_history(walls, closed):
    load = {"max_normal_stress": TARGET, "seating_stress": 0.0}
    other = jc.simulate(*walls, spacing=SPACING, rock=DOLERITE, **load)
    xr.testing.assert_equal(other.closure, closed.closure)
    np.testing.assert_array_equal(other.max_closure_seated, other.max_closure)
    assert np.all(closed.max_closure_seated < closed.max_closure)


@pytest.mark.parametrize("method", [("fast", "resolved"), ("reference", "fixed_step")], ids=str)
def test_a_process_of_its_own_gives_the_same_bits(walls, method, tmp_path):
    """By every method; that of the study is compared in tests/workflow."""
    solver, breakage = method
    numerics = jc.Numerics(solver=solver, breakage=breakage)
    stated = {"spacing": SPACING, "rock": DOLERITE, "max_normal_stress": 1e6, "numerics": numerics}
    file = tmp_path / "closed.nc"
    script = (
        "import sys\nimport jointclosure as jc\nfrom jointclosure import Numerics, Rock\n"
        "from jointclosure.storage.netcdf import write_netcdf\n"
        f"walls = jc.wall_pair(8.0, (24, 24), {SPACING!r}, seed=11)\n"
        f"write_netcdf(jc.simulate(*walls, **{stated!r}), sys.argv[1])\n"
    )
    subprocess.run([sys.executable, "-c", script, str(file)], check=True)
    here, there = jc.simulate(*walls, **stated), read_netcdf(file)
    for name, variable in here.data_vars.items():
        assert there[name].values.tobytes() == variable.values.tobytes(), name


def test_the_same_call_gives_the_same_numbers_and_leaves_the_walls_alone(walls, closed):
    copies = [wall.copy() for wall in walls]
    again = jc.simulate(
        *walls, spacing=SPACING, rock=DOLERITE, max_normal_stress=TARGET, seating_stress=5e5
    )
    xr.testing.assert_identical(again, closed)
    for wall, copy in zip(walls, copies, strict=True):
        np.testing.assert_array_equal(wall, copy)


def test_without_breakage_loading_and_unloading_are_one_curve(walls):
    effects = jc.Effects(breakage=False, gouge=False)
    elastic = jc.simulate(
        *walls,
        spacing=SPACING,
        rock=DOLERITE,
        max_normal_stress=TARGET,
        effects=effects,
        numerics=jc.Numerics(force_tolerance=1e-8),
    )
    for closure, stress in zip(
        elastic.closure.values[::4], elastic.normal_stress.values[::4], strict=True
    ):
        state = jc.equilibrium(
            *walls,
            spacing=SPACING,
            rock=DOLERITE,
            closure=float(closure),
            effects=effects,
            numerics=jc.Numerics(force_tolerance=1e-8),
        )
        assert float(state.normal_stress) == pytest.approx(stress, rel=1e-7, abs=1e-3)
    assert elastic.max_closure.values[0] == pytest.approx(elastic.max_closure.values[1], rel=1e-3)
    np.testing.assert_array_equal(elastic.residual_closure, 0.0)


@pytest.mark.parametrize("breakage", [False, True])
def test_an_offset_of_the_heights_costs_no_digits(walls, breakage):
    offset = 2.0**8  # a million times the roughness
    upper, lower = (np.round(wall * 2.0**40) / 2.0**40 for wall in walls)
    assert np.array_equal(upper + offset - offset, upper)
    setting = {
        "spacing": SPACING,
        "rock": DOLERITE,
        "max_normal_stress": TARGET,
        "effects": jc.Effects(breakage=breakage, gouge=breakage),
    }
    plain = jc.simulate(upper, lower, **setting)
    lifted = jc.simulate(upper + offset, lower - offset, **setting)
    np.testing.assert_array_equal(lifted.closure, plain.closure)
    np.testing.assert_array_equal(lifted.normal_stress, plain.normal_stress)
    np.testing.assert_allclose(lifted.upper_final, plain.upper_final + offset, rtol=1e-15)
    assert lifted.upper_final.attrs == plain.upper_final.attrs


def test_walls_about_zero_are_left_as_they_are(walls):
    assert [height_datum(wall) for wall in walls] == [0.0, 0.0]
    assert height_datum(np.full((3, 3), 0.1)) == 0.1
    assert abs(height_datum(walls[0] + 0.3) - 0.3) <= 2 * np.ptp(walls[0])


def test_interpolation_is_the_papers_and_meets_the_target_exactly(walls):
    closed = jc.simulate(
        *walls,
        spacing=SPACING,
        rock=DOLERITE,
        max_normal_stress=TARGET,
        numerics=jc.Numerics(target="interpolate"),
    )
    for cycle in (1, 2):
        assert on(closed, cycle, "loading")[1][-1] == pytest.approx(TARGET, rel=1e-12)


@pytest.mark.parametrize("target", ["equilibrate", "interpolate"])
def test_every_step_of_unloading_counts_from_where_the_last_one_ended(walls, target):
    """Also the first after an interpolation, which lies before the step that overshot."""

    begun = []

    class Watched(FastSolver):
        def settle(self, joint, closure, breakage_step):
            begun.append((float(joint.closure), closure))
            return super().settle(joint, closure, breakage_step)

    with patch.dict(SOLVERS, fast=Watched):
        closed = jc.simulate(
            *walls,
            spacing=SPACING,
            rock=DOLERITE,
            max_normal_stress=TARGET,
            numerics=jc.Numerics(target=target),
        )
    for cycle in (1, 2):
        steps = on(closed, cycle, "unloading")[0]
        assert set(itertools.pairwise(steps)) <= set(begun)


def test_two_rocks_swap_with_their_walls(walls):
    soft = jc.Rock(20e9, 0.3, 60e6)
    elastic = jc.Effects(breakage=False, gouge=False)
    one = jc.equilibrium(
        *walls, spacing=SPACING, rock=(DOLERITE, soft), closure=1e-4, effects=elastic
    )
    other = jc.equilibrium(
        *walls[::-1], spacing=SPACING, rock=(soft, DOLERITE), closure=1e-4, effects=elastic
    )
    np.testing.assert_allclose(one.force, other.force, rtol=1e-9, atol=1e-12)
    mixed = jc.simulate(*walls, spacing=SPACING, rock=(DOLERITE, soft), max_normal_stress=1e6)
    assert int(mixed.status) < FAILURE


SCENES = list(well_posed_scenes())


@pytest.mark.parametrize("breakage", ["fixed_step", "resolved"])
@pytest.mark.parametrize("effects", SCENES, ids=str)
def test_every_scene_closes(effects, breakage):
    walls = jc.wall_pair(6.0, (12, 12), SPACING, seed=2)
    closed = jc.simulate(
        *walls,
        spacing=SPACING,
        rock=DOLERITE,
        max_normal_stress=2e5,
        seating_stress=0.0,
        cycles=1,
        effects=effects,
        numerics=jc.Numerics(breakage=breakage),
    )
    assert int(closed.status) < FAILURE, FLAGS
    assert closed.max_closure.values[0] > 0.0
    if not effects.breakage:
        np.testing.assert_array_equal(closed.upper_final, walls[0])


NUMERICS, CHOICES = jc.Numerics(), jc.Choices()  # changed by _replace, which checks nothing


@pytest.mark.parametrize(
    ("change", "named"),
    [
        ({"rock": jc.Rock._make((-1.0, 0.2, 1e8))}, "youngs_modulus = -1.0"),
        ({"rock": 3.0}, "rock"),
        ({"rock": jc.Rock._make((1e9, "a", 1e8))}, "poisson_ratio = 'a': must be a number"),
        (
            {"rock": jc.Rock._make((78, 0.2, 165)), "unusual_values": True},
            "max_normal_stress = 1000000.0 Pa: must be below",
        ),
        ({"spacing": "x"}, "spacing = 'x'"),
        ({"cycles": True}, "cycles = True"),
        ({"effects": {"gouge": False}}, "must be an Effects"),
        ({"upper": np.ma.masked_array(np.zeros((4, 4)), np.eye(4))}, "masked"),
        ({"upper": [[1.0, 2.0], [3.0]]}, "upper: is not an array"),
        ({"seating_stress": 2e6}, "seating_stress = 2000000.0"),
        ({"effects": jc.Effects(substrate=False)}, "interaction"),
        (
            {"choices": CHOICES._replace(base_radius_in_cells=1.5)},
            "base_radius_in_cells = 1.5",
        ),
        (
            {"choices": CHOICES._replace(largest_radius=1e-4)},
            "0.0001 m: must be at least the grid",
        ),
        ({"choices": CHOICES._replace(peaks="some")}, "peaks = 'some'"),
        ({"numerics": NUMERICS._replace(breakage_step=12.5e-6)}, "breakage_step = 1.25e-05"),
        (
            {"numerics": NUMERICS._replace(later_breakage_step=7e-6)},
            "later_breakage_step = 7e-06",
        ),
        ({"numerics": NUMERICS._replace(breakage="some")}, "breakage = 'some'"),
        (
            {"numerics": NUMERICS._replace(breakage="resolved", solver="reference")},
            "not with solver = 'reference'",
        ),
        (
            {"numerics": NUMERICS._replace(breakage="resolved", target="interpolate")},
            "interpolate",
        ),
        ({"upper": np.zeros((4, 5))}, "shapes"),
        ({"lower": np.full((4, 4), np.nan)}, "lower: 16 values are not finite"),
        ({"lower": np.zeros((4, 4), dtype=complex)}, "lower: values of type complex128"),
    ],
)
def test_bad_input_is_refused_by_name(change, named):
    good = {
        "upper": np.zeros((4, 4)),
        "lower": np.zeros((4, 4)),
        "spacing": SPACING,
        "rock": DOLERITE,
        "max_normal_stress": 1e6,
    }
    with pytest.raises(jc.InputError, match=named.replace("(", r"\(")):
        jc.simulate(**(good | change))


def test_a_rigid_contact_is_a_status_and_not_a_number():
    flat = np.zeros((4, 4))
    closed = jc.simulate(
        flat,
        flat,
        spacing=SPACING,
        rock=DOLERITE,
        max_normal_stress=1e6,
        effects=jc.Effects(substrate=False, interaction=False, breakage=False, gouge=False),
    )
    assert FLAGS[int(closed.status)] == "rigid_contact"
    assert np.isnan(closed.max_closure.values).all()


@pytest.mark.parametrize("offset", [0.0, -0.9, 5.0, 40.0, -1e6])
def test_the_datum_of_heights_is_subtracted_and_added_without_rounding(offset):
    wall = np.random.default_rng(3).standard_normal((30, 30)) + offset
    datum = height_datum(wall)
    np.testing.assert_array_equal((wall - datum) + datum, wall)
    if abs(offset) > 100.0:
        assert np.abs(wall - datum).max() < 20.0


@pytest.mark.parametrize("breakage", [False, True])
def test_a_tilted_ridge_is_flat_though_rounding_leaves_it_a_curvature(breakage):
    y, x = np.mgrid[:9, :9] * 1.0
    ridge = 1e-5 * (0.3 * y - np.abs(x - 4.0))  # straight along y; the other wall is as tilted
    curvature = np.diff(ridge[:, 4], 2)
    assert 0.0 < np.abs(curvature).max() < 1e-19  # all rounding
    closed = jc.simulate(
        ridge,
        -0.3e-5 * y,
        spacing=1e-4,
        rock=jc.Rock(78e9, 0.2, 165e6),
        max_normal_stress=1e7,
        effects=jc.Effects(breakage=breakage, gouge=False),
    )
    assert float(closed.flat_share.max()) > 0.5


def test_every_step_is_reported_as_it_is_taken(rock, small_joint):
    stated = []
    closed = jc.simulate(
        *small_joint,
        spacing=SPACING,
        rock=rock,
        max_normal_stress=1e6,
        report=lambda *step: stated.append(step),
    )
    assert [step[0] for step in stated] == closed.cycle.values.tolist()
    assert [step[1] for step in stated] == closed.branch.values.tolist()
    np.testing.assert_allclose([step[2] for step in stated], closed.normal_stress / 1e6, rtol=1e-12)


@pytest.mark.parametrize("stress", [3e6, 5e6, 30e6])
def test_seating_at_a_step_of_an_elastic_curve_makes_no_step_of_no_length(stress):
    """0.5 MPa is one of sixty stresses, but for rounding."""
    closed = jc.simulate(
        *jc.wall_pair(8.0, (8, 8), SPACING, seed=1), spacing=SPACING, rock=DOLERITE, cycles=1,
        max_normal_stress=stress, effects=jc.Effects(breakage=False, gouge=False),
    )  # fmt: skip
    loading = closed.normal_stress.values[closed.branch.values == "loading"]
    assert np.diff(loading).min() > 1e-3 * stress

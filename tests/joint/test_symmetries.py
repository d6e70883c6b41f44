"""What a joint may not depend on: the names of the walls, the axes of the grid."""

import functools

import numpy as np
import pytest

import jointclosure as jc
from jointclosure.joint.status import FAILURE
from tests import joints
from tests.joints import DOLERITE, SPACING

SOFT = jc.Rock(20e9, 0.3, 60e6)
ELASTIC = {
    "asperities": jc.Effects(False, False, False, False, True),
    "substrate": jc.Effects(True, False, False, False, True),
    "interaction": jc.Effects(True, True, False, False, True),
}
MAPS = {
    "walls swapped": lambda upper, lower: (lower, upper),
    "transposed": lambda upper, lower: (upper.T, lower.T),
    "mirrored in x": lambda upper, lower: (upper[:, ::-1], lower[:, ::-1]),
    "mirrored in y": lambda upper, lower: (upper[::-1], lower[::-1]),
    "turned": lambda upper, lower: (np.rot90(upper), np.rot90(lower)),
}


@pytest.mark.parametrize("name", MAPS)
@pytest.mark.parametrize("scene", ELASTIC)
def test_elastic_forces_map_with_the_joint(small_joint, scene, name):
    # hard walls carry more than a usual stress
    about = {"effects": ELASTIC[scene], "force_tolerance": 1e-12, "unusual_values": True}
    one = joints.balanced(small_joint, 3e-4, rock=(DOLERITE, SOFT), **about)
    rock = (SOFT, DOLERITE) if name == "walls swapped" else (DOLERITE, SOFT)
    other = joints.balanced(MAPS[name](*small_joint), 3e-4, rock=rock, **about)
    # solved to a residual of 1e-12 of the sum of all forces, so no force is off by more
    expected = MAPS[name](one.force.values, one.force.values)[0]
    np.testing.assert_allclose(other.force, expected, rtol=0.0, atol=1e-10 * expected.sum())
    np.testing.assert_allclose(other.normal_stress, one.normal_stress, rtol=1e-10)


@functools.lru_cache(maxsize=None)
def coarse(seed, breakage, name="", swapped=False):
    """A small joint of two rocks, as a map has it, in coarse steps: symmetric like any other."""
    walls = jc.wall_pair(8.0, (20, 16), SPACING, seed=seed)
    about = {"rock": (SOFT, DOLERITE) if swapped else (DOLERITE, SOFT), "largest_radius": 20e-3}
    about |= {"breakage": breakage, "seating_stress": 0.0}
    if breakage == "resolved":
        about["tolerance"] = 0.1
    return joints.closed(MAPS[name](*walls) if name else walls, unusual_values=True, **about)


@pytest.mark.slow
@pytest.mark.parametrize("breakage", ["fixed_step", "resolved"])
@pytest.mark.parametrize("name", ["walls swapped", "transposed", "turned"])
def test_with_breakage_closures_map_in_the_mean(name, breakage):
    """The mean difference is within three of its standard errors, which are small enough.

    A bias beyond three standard errors is seen: they are at most 2 % of the mean closure of the
    first cycle, and 4 % of the second's, whose closure is a tenth as large.
    """
    pairs = []
    for seed in range(160):
        one = coarse(seed, breakage)
        other = coarse(seed, breakage, name, name == "walls swapped")
        assert max(int(one.status), int(other.status)) < FAILURE
        pairs.append([one.max_closure.values, other.max_closure.values])
    first, second = np.array(pairs).swapaxes(0, 1)
    difference, mean = second - first, first.mean(axis=0)
    error = difference.std(axis=0, ddof=1) / np.sqrt(len(pairs))
    assert np.all(3.0 * error <= np.array([0.02, 0.04]) * mean), 3.0 * error / mean
    assert np.all(np.abs(difference.mean(axis=0)) <= 3.0 * error + 1e-12 * mean)


def bowls(towards):
    """Walls (y, x) of parabolas with curvatures [1/m] along x and y: ((x, y) above, below)."""
    x = (np.arange(41) - 20) * SPACING
    along = [-0.5 * x[None, :] ** 2, -0.5 * x[:, None] ** 2]
    return tuple(sum(k * part for k, part in zip(wall, along, strict=True)) for wall in towards)


@pytest.fixture(
    scope="module", params=[ELASTIC["interaction"], jc.Effects()], ids=["elastic", "all"]
)
def same_sums(request):
    """The paper's Fig. 1: effects, and joints with the same sums of heights of other walls."""
    walls = {
        "composite": ((50.0, 50.0), (0.0, 0.0)),
        "halves": ((25.0, 25.0), (25.0, 25.0)),
        "crossed cylinders": ((50.0, 0.0), (0.0, 50.0)),
        "peak in a hollow": ((100.0, 100.0), (-50.0, -50.0)),
    }
    about = {"effects": request.param, "strength_bound": "none"}
    return request.param, {
        name: joints.closed(bowls(pair), 3e6, **about) for name, pair in walls.items()
    }


def first_closures(closed):
    return {name: float(joint.max_closure[0]) for name, joint in closed.items()}


def test_a_composite_describes_walls_of_one_shape(same_sums):
    first = first_closures(same_sums[1])
    assert first["halves"] == pytest.approx(first["composite"], rel=3e-3)


def test_a_composite_does_not_describe_walls_of_other_shapes(same_sums):
    effects, closed = same_sums
    first = first_closures(closed)
    assert first["crossed cylinders"] < 0.92 * first["composite"]
    assert first["peak in a hollow"] > 1.04 * first["composite"]
    assert float(closed["crossed cylinders"].flat_share[0]) == pytest.approx(1.0)
    if effects.breakage:
        broken = {name: int(joint.breakage_steps.sum()) for name, joint in closed.items()}
        assert broken["crossed cylinders"] == 0 < broken["composite"]
        assert first["peak in a hollow"] > 1.5 * first["composite"]

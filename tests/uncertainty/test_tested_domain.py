"""Walls outside of the domain in which ranges of results were tested are named."""

import warnings
from types import SimpleNamespace

import numpy as np
import pytest

import jointclosure as jc
from benchmarks.range_coverage import inputs
from jointclosure.uncertainty.tested_domain import TESTED, beyond_tested
from jointclosure.walls.gridding import Scan
from tests.joints import ELASTIC, SPACING, pair


def walls(angle=0.0, tilt=0.0, noise=0.0):
    motion = SimpleNamespace(angle=angle, tilt=tilt)
    return SimpleNamespace(motion=motion, scan_noise=(("lower", noise, 2.0 * noise),))


@pytest.mark.parametrize(
    ("beyond", "named"),
    [
        ({"angle": -12.0}, "turned by 12 degrees from a quarter turn of the grid (tested: up to 7"),
        ({"angle": 100.0}, "turned by 10 degrees"),
        ({"tilt": 4.0}, "tilted by 4 degrees (tested: up to 3)"),
        ({"noise": 20e-6}, "the noise of the lower wall is at least 20 um (tested: up to 15)"),
    ],
)
def test_what_lies_outside_of_the_tested_domain_is_named(beyond, named):
    (line,) = beyond_tested(walls(**beyond))
    assert named in line


@pytest.mark.parametrize("angle", [0.0, 6.9, -6.9, 180.0, -90.0, 173.5])
def test_walls_inside_of_the_tested_domain_have_no_line(angle):
    assert beyond_tested(walls(angle, 2.9, 14e-6)) == []
    assert beyond_tested(walls(angle, 2.9, np.nan)) == []


def test_the_pairs_of_the_benchmark_are_the_tested_domain():
    drawn = [inputs(number)[0] for number in range(2000, 2060)]
    for name, most in TESTED._asdict().items():
        sizes = [abs(stated[name]) for stated in drawn]
        assert 0.9 * most < max(sizes) <= most


@pytest.mark.parametrize(("single", "unusual"), [(False, False), (False, True), (True, False)])
def test_close_says_it_of_results_that_have_a_range(single, unusual):
    upper, lower = pair((24, 28))
    noise = 2e-4 * np.random.default_rng(1).standard_normal((2, *upper.shape))
    heights = np.add(noise, (3e-3 - upper, lower))
    scans = [Scan(wall, (SPACING, SPACING), (0.0, 0.0)) for wall in heights]
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        joint = jc.close(
            *scans, rock="granite", max_normal_stress=1e6, cycles=1, effects=ELASTIC, workers=1,
            orientation="common_frame", single=single, unusual_values=unusual,
        )  # fmt: skip
    untested = "were not tested on such walls"
    assert any(untested in line for line in joint.pair.remarks) == (not single)
    assert any(untested in str(w.message) for w in caught) == (not single and not unusual)

"""Walls outside of the domain in which ranges of results were tested are named."""

import warnings
from types import SimpleNamespace

import numpy as np
import pytest

import jointclosure as jc
from benchmarks.range_coverage import ROUGH, SMOOTH, inputs
from jointclosure.uncertainty import tested_domain
from jointclosure.uncertainty.tested_domain import TESTED, beyond_tested
from jointclosure.walls.gridding import Scan
from jointclosure.walls.jrc import DEFAULT_RELATION, RELATIONS, z2_of_jrc
from tests.joints import ELASTIC, SPACING, pair


def walls(angle=0.0, tilt=0.0, noise=0.0, steeper=1.0):
    upper, lower = (steeper * wall for wall in pair(24))
    return SimpleNamespace(
        motion=SimpleNamespace(angle=angle, tilt=tilt),
        scan_noise=(("lower", noise, 2.0 * noise),),
        upper=upper, lower=lower, spacing=SPACING,
    )  # fmt: skip


@pytest.mark.parametrize(
    ("beyond", "named"),
    [
        ({"tilt": 8.5}, "tilted by 8.5 degrees (tested: up to 8)"),
        ({"steeper": 3.0}, "their JRC is "),
        ({"noise": 20e-6}, "the noise of the lower wall is at least 20 um (tested: up to 15)"),
    ],
)
def test_what_lies_outside_of_the_tested_domain_is_named(beyond, named):
    (line,) = beyond_tested(walls(**beyond))
    assert line.startswith("ranges of the results were not tested on such walls: ")
    assert named in line


@pytest.mark.parametrize("angle", [-12.0, 100.0])
def test_rotations_count_from_a_quarter_turn(angle, monkeypatch):
    """No rotation is beyond the domain of `TESTED`, which ends halfway between quarter turns."""
    assert beyond_tested(walls(angle)) == []
    monkeypatch.setattr(tested_domain, "TESTED", SMOOTH)
    (line,) = beyond_tested(walls(angle))
    turned = f"turned by {min(abs(angle), abs(angle - 90.0)):g} degrees from a quarter turn"
    assert f"{turned} of the grid (tested: up to 7)" in line


@pytest.mark.parametrize("angle", [0.0, 6.9, -6.9, 180.0, -90.0, 173.5, 30.0])
def test_walls_inside_of_the_tested_domain_have_no_line(angle):
    assert beyond_tested(walls(angle, 7.9, 14e-6)) == []
    assert beyond_tested(walls(angle, 7.9, np.nan)) == []


@pytest.mark.parametrize(("first", "domain"), [(2000, SMOOTH), (ROUGH, TESTED)])
def test_the_pairs_of_the_benchmark_are_the_tested_domain(first, domain):
    drawn = [inputs(number)[0] for number in range(first, first + 60)]
    relation = RELATIONS[DEFAULT_RELATION]
    for stated in drawn:
        slope = z2_of_jrc(stated["jrc"], relation.interval, 0.8) * stated.get("steepness", 1.0)
        stated["jrc"] = float(relation.jrc(slope))
    for name, most in domain._asdict().items():
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

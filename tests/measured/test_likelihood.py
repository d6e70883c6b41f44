"""A joint fitted to its measured closure: the interval covers the mismatch it was made with."""

import functools
from types import SimpleNamespace

import numpy as np
import pytest

import jointclosure as jc
from jointclosure.joint.conditions import Conditions
from jointclosure.joint.history import history_of
from jointclosure.joint.simulation import simulate_walls
from jointclosure.measured.curves import MeasuredCurve, parsed_curve
from jointclosure.measured.fit import fit
from jointclosure.measured.joint_arguments import WallRecipe
from jointclosure.measured.likelihood import (
    likelihood_of,
    log_readings,
    readings_of_curve,
    readings_of_history,
)
from jointclosure.measured.simulated_joints import (
    ABOUT_RANGES,
    ComparisonJoints,
    LaterLoading,
    numerical_sentence,
)
from jointclosure.plotting.measured import fit_figure
from tests.joints import COARSE, SPACING
from tests.measured.test_validation import scanned_pair

GRANITE = jc.Rock(73e9, 0.25, 173e6)
SHAPE, STRESS, SEATING = (24, 24), 5e6, 0.5e6
PAPER = jc.Choices(strength_bound="none")
CONDITIONS = Conditions(SPACING, GRANITE, STRESS, 1, SEATING, jc.Effects(), PAPER, jc.Numerics())
WAVELENGTHS = np.geomspace(3.0 * SPACING, SHAPE[0] * SPACING, 5)


WALLS = WallRecipe((10.0, 10.0), SHAPE, SPACING, 1, 0.8, 3e-3)
walls = functools.partial(WALLS.pair, scans=None)


def closures_of(asked, wavelengths, surfaces):
    """Closures (wavelengths, joints, cycles, 2, stresses) [m] of simulated joints."""
    given = SimpleNamespace(
        joint=SimpleNamespace(surfaces=surfaces), measured=asked, wavelengths=wavelengths,
        walls=WALLS, scans=None,
    )  # fmt: skip
    made = CONDITIONS, (GRANITE.compressive_strength,), (surfaces, 0, 1), (LaterLoading(),)
    joints = ComparisonJoints(given, *made, None, 1, lambda line: None)
    return joints.closures()[0, :, 0], joints.stresses


def curve_of(history):
    """A history as a laboratory would have measured it, the rock's deformation subtracted."""
    read = history_of(history)
    steps = np.concatenate([branch.steps for branch in read.cycles[0].branches])
    stress, closure = read.stress[steps], read.net.values[steps]
    return MeasuredCurve(stress, closure + 3e-4, np.ones(steps.size, int), steps)


@pytest.fixture(scope="module")
def simulated(history):
    asked = readings_of_curve(curve_of(history), SEATING)
    return log_readings(*closures_of(asked, WAVELENGTHS, 10), asked)[:, None]


@pytest.fixture(scope="module")
def history():
    return simulate_walls(*walls(1, 2e-3), CONDITIONS.checked())


def test_a_curve_is_read_as_the_history_that_it_was_measured_of(history):
    measured = readings_of_curve(curve_of(history), SEATING)
    assert measured.unloaded == (1,)
    np.testing.assert_allclose(measured.levels, [1.625e6, 2.75e6, 5e6], rtol=2e-3)
    # wherever a laboratory's closures start; it knows of no landing
    read = readings_of_history(history.assign_attrs(numerics="{}"), measured)
    np.testing.assert_allclose(read, measured.values)
    assert measured.names()[-1] == "closure recovered in cycle 1"
    assert len(measured.names()) == len(measured.values)


def test_curves_of_the_joints_are_those_of_the_readings(history):
    asked = readings_of_curve(curve_of(history), SEATING)
    asked = asked._replace(cycles=2, unloaded=(1, 2), read=())
    asked = asked._replace(values=np.ones(len(asked.places())))
    closures, stresses = closures_of(asked, WAVELENGTHS[:2], 1)
    readings = np.exp(log_readings(closures, stresses, asked))[:, 0].reshape(2, 2, -1)
    assert np.isfinite(readings).all()  # of both cycles, the last recovered
    loading, unloading = np.moveaxis(closures[:, 0] - closures[:, 0, :, :1, :1], 2, 0)
    assert (stresses[0], stresses[-1]) == (SEATING, asked.levels[-1])
    np.testing.assert_allclose(loading[:, :, -1], readings[:, :, -2], rtol=1e-12)
    recovered = loading[:, :, -1] - unloading[:, :, 0]
    np.testing.assert_allclose(recovered, readings[:, :, -1], rtol=1e-12)
    whole = simulate_walls(*walls(1, WAVELENGTHS[0]), CONDITIONS._replace(cycles=2).checked())
    np.testing.assert_array_equal(closures[0, 0], history_of(whole).net.at(stresses))


def test_the_interval_covers_the_mismatch_wavelength_of_synthetic_joints(simulated):
    held, stated = [], []
    for number in range(24):
        truth = float(np.exp(np.random.default_rng(number).uniform(*np.log([1e-3, 4e-3]))))
        curve = curve_of(simulate_walls(*walls(10_000 + number, truth), CONDITIONS.checked()))
        measured = readings_of_curve(curve, SEATING)
        found = likelihood_of(measured, simulated, WAVELENGTHS, np.array([173e6]), 0.02)
        value, low, high = found.interval(0)
        held.append(low <= truth <= high)
        stated.append(min(high, WAVELENGTHS[-1]) / max(low, WAVELENGTHS[0]))
        assert low <= value <= high
    assert np.mean(held) >= 0.85
    # and it says something, of a range of eight
    assert np.median(stated) < 5.0


def made_up(rng, wavelength, strength, count):
    """Log readings of a law of mismatch and strength, with a scatter of 10 %."""
    x, y = np.log(wavelength), np.log(strength / 160e6)
    mean = np.array([-9.0, -8.5, -8.0]) + 0.8 * x - np.array([0.2, 0.5, 0.9]) * y
    return mean + 0.1 * rng.standard_normal((count, 3))


@pytest.fixture(scope="module")
def likelihood():
    """Function that gives the likelihood of log readings among joints that follow `made_up`."""
    rng = np.random.default_rng(5)
    wavelengths, strengths = np.geomspace(1e-3, 8e-3, 6), np.geomspace(80e6, 320e6, 4)
    simulated = np.array([[made_up(rng, w, s, 12) for s in strengths] for w in wavelengths])
    curve = readings_of_curve(parsed_curve(GOOD, "lab.csv", cycle=1), SEATING)
    return lambda logs: likelihood_of(
        curve._replace(values=np.exp(logs)), simulated, wavelengths, strengths, 0.02
    )


def test_intervals_of_mismatch_and_strength_cover_both(likelihood):
    rng = np.random.default_rng(6)
    held = []
    for _ in range(60):
        truth = np.exp(rng.uniform(*np.log([1.5e-3, 5e-3]))), rng.uniform(110e6, 230e6)
        found = likelihood(made_up(rng, *truth, 1)[0])
        ends = found.interval(0)[1:], found.interval(1)[1:]
        held.append([low <= value <= high for value, (low, high) in zip(truth, ends, strict=True)])
    assert np.all(np.mean(held, axis=0) >= 0.88)
    assert 0.001 < found.p_value <= 1.0


def test_a_curve_of_another_law_is_one_that_such_joints_do_not_make(likelihood):
    assert likelihood([-8.0, -8.5, -9.0]).p_value < 1e-6


def readings_of(rows):
    """Readings of a curve by its rows of stress, closure and cycle."""
    return readings_of_curve(parsed_curve(HEAD + rows, "lab.csv"), SEATING)


HEAD = "stress_MPa,closure_mm,cycle\n"
TWO_CYCLES = f"""{HEAD}0,0,1\n1,0.05,1\n2,0.08,1\n5,0.12,1\n0,0.09,1
0,0.09,2\n1,0.1,2\n2,0.11,2\n5,0.12,2\n0,0.09,2
"""
GOOD = "stress_MPa,closure_mm\n0,0\n0.5,0.02\n1,0.05\n2,0.08\n5,0.12\n"


ABOUT = {"rock": "granite", "shape": (8, 8), "surfaces": 4, "workers": 1, "numerics": COARSE}


@pytest.fixture(scope="module")
def lab(tmp_path_factory):
    path = tmp_path_factory.mktemp("lab") / "lab.csv"
    path.write_text(GOOD)
    return path


@pytest.fixture(scope="module")
def found(lab):
    return fit(lab, jrc=10.0, **ABOUT, cache=lab.parent)


def test_joints_of_a_fit_are_not_closed_again(found, lab, capsys):
    again = fit(lab, jrc=10.0, **ABOUT, cache=lab.parent, progress=True)
    assert "closed" not in capsys.readouterr().out
    assert again.p_value == found.p_value


def test_only_the_joints_that_a_fit_lacks_are_closed(found, lab, capsys):
    (joint, *_) = lab.parent.glob("wavelength_*.nc")
    joint.unlink()
    again = fit(lab, jrc=10.0, **ABOUT, cache=lab.parent, progress=True)
    assert "closed: 1 of 1" in capsys.readouterr().out
    assert again.p_value == found.p_value


def test_a_fit_doubts_a_curve_that_no_joint_makes(found, tmp_path):
    assert found.compressive_strength is None
    assert found.interval_holds
    assert found.simulated.logs.shape == (8, 1, 4, 3)
    assert found.numerical.keys() == {one.name for one in found.agreements() if one.unit != "%"}
    assert any("closure of cycle 1" in line for line in numerical_sentence(found.numerical))
    assert numerical_sentence(found.numerical)[0] in found.sentences()
    path = tmp_path / "lab.csv"
    path.write_text(GOOD.replace("0.12", "15"))
    odd = fit(path, jrc=10.0, **ABOUT, simulated=found.simulated)
    assert not odd.interval_holds
    assert odd.p_value < 1e-3
    assert odd.mismatch_wavelength.value == np.inf
    assert [one.missed for one in odd.agreements()] == [True, True]


def test_a_range_of_jrc_widens_the_scatter_of_the_joints(found, lab):
    several = fit(lab, jrc=(2.0, 18.0), **ABOUT)
    assert several.likelihood.scatter[-1, -1] > found.likelihood.scatter[-1, -1]
    for wrong in (None, (18.0, 2.0), (1.0, 2.0, 3.0)):
        with pytest.raises(jc.InputError, match="jrc"):
            fit(lab, jrc=wrong, **ABOUT)


def test_the_strength_of_scanned_walls_is_within_its_interval():
    pair = scanned_pair(24)
    weak = GRANITE._replace(compressive_strength=130e6)
    curve = curve_of(
        simulate_walls(pair.upper, pair.lower, CONDITIONS._replace(rock=weak).checked())
    )
    given = {"rock": GRANITE, "pair": pair, "seating_stress": SEATING, "choices": PAPER}
    result = fit(curve, **given, surfaces=6, workers=1, numerics=COARSE)
    assert result.scanned
    assert result.mismatch_wavelength == pair.mismatch
    assert result.compressive_strength.low <= 130e6 <= result.compressive_strength.high
    closure = result.agreements()[0]
    assert closure.low <= 130e6 <= closure.high
    assert fit_figure(result, "a joint").axes


def test_a_cycle_measured_from_a_new_zero_is_read_as_one_that_continues():
    rows = "0.5,0,1\n5,0.1,1\n0.5,0.05,1\n"
    later = "0.5,{},2\n2.75,{},2\n5,{},2\n"
    texts = (rows + later.format(zero, zero + 0.03, zero + 0.05) for zero in (0.0, 0.05))
    np.testing.assert_allclose(*(readings_of(text).values for text in texts))


@pytest.mark.parametrize(
    ("text", "about", "printed"),
    [
        (GOOD.replace("0,0\n0.5", "0.8,0\n0.9"), {}, "must start at or below seating_stress"),
        (GOOD.replace("0.12", "0.01"), {}, "closure of cycle 1 must increase"),
        (GOOD.replace("_mm", "_m"), {}, "closures range over 120 mm: must be at most 20 mm"),
        (HEAD + "0,0,1\n5,1,1\n0,0.5,1\n0,0.5,2\n4,1,2\n", {}, "to 4 MPa and cycle 1 to 5 MPa"),
        (TWO_CYCLES, {"surfaces": 4}, "surfaces = 4: must be at least 5 for this curve"),
        (GOOD, {"shape": 16}, "shape = 16: must be (cells along y"),
    ],
)
def test_a_curve_that_cannot_be_fitted_is_refused_in_a_line(tmp_path, text, about, printed):
    path = tmp_path / "lab.csv"
    path.write_text(text)
    with pytest.raises(jc.InputError) as error:
        fit(path, **({"rock": "granite", "jrc": 10.0, "shape": (64, 64)} | about))
    assert printed in str(error.value)
    assert "\n" not in str(error.value)


def test_the_first_loading_of_a_curve_that_loses_more_than_the_model_is_fitted_alone(found, lab):
    loading = [f"{line},1\n" for line in GOOD.splitlines()[1:]]
    later = TWO_CYCLES.replace("2,5", "2,9").split("0.12,1\n")[1].replace("0.12,2", "0.15,2")
    lossy = lab.with_name("lossy.csv")
    lossy.write_text("".join([HEAD, *loading, later]))
    alone = fit(lossy, jrc=10.0, **ABOUT, first_loading=True, simulated=found.simulated)
    assert alone.p_value == found.p_value
    assert alone.assumed == f"{found.assumed}; only the first loading is fitted"
    both = fit(lossy, jrc=10.0, **ABOUT | {"surfaces": 5})
    assert not both.interval_holds
    assert "first_loading=True (--first-loading) fits alone" in both.sentences()[0]
    assert "is farther from the mean of the simulated joints than" in both.sentences()[0]
    assert ABOUT_RANGES in both.sentences()
    # without a panel of the likelihood, of which no interval is valid
    labels = [axes.get_ylabel() for axes in fit_figure(both, "a joint").axes]
    assert sorted(labels) == ["normal stress (MPa)", "simulated over measured"]


def test_two_loadings_are_read_without_the_unloading_between_them():
    first, later = "0.5,0,1\n2.75,0.08,1\n5,0.1,1\n", "0.5,0.05,2\n2.75,.08,2\n5,.1,2\n"
    whole, loadings = (readings_of(text + later) for text in (first + "0.5,0.05,1\n", first))
    kept = [number for number, (_, level) in enumerate(whole.places()) if level is not None]
    assert loadings.places() == [whole.places()[number] for number in kept]
    np.testing.assert_allclose(loadings.values, whole.values[kept])

"""Variance indices of a mean over noisy surfaces, on functions whose indices are known."""

import numpy as np
import pytest

import jointclosure as jc
from jointclosure.statistics.variance_indices import (
    _shapley_values,
    design_matrix,
    fit_function,
    level_of,
    sampled_rows,
    shapley_effects,
    terms_of,
    variance_indices,
)


def ishigami(u):
    """Ishigami and Homma's function (a = 7, b = 0.1): its inputs act together."""
    x = np.pi * (2.0 * u - 1.0)
    return np.sin(x[..., 0]) * (1.0 + 0.1 * x[..., 2] ** 4) + 7.0 * np.sin(x[..., 1]) ** 2


_BY_1 = 0.5 * (1.0 + 0.1 * np.pi**4 / 5.0) ** 2
_BY_13 = 0.01 * np.pi**8 * (1.0 / 18.0 - 1.0 / 50.0)
_WHOLE = _BY_1 + 49.0 / 8.0 + _BY_13
FIRST = np.array([_BY_1, 49.0 / 8.0, 0.0]) / _WHOLE
TOTAL = np.array([_BY_1 + _BY_13, 49.0 / 8.0, _BY_13]) / _WHOLE


def noisy(number: int, rows: int = 64, noise: float = 1.5):
    """Ishigami's function with the surfaces' noise: of a row, and a little of every joint."""
    points = sampled_rows(3, rows, number)
    random = np.random.default_rng(1000 + number)
    surface = random.standard_normal((rows, 1, 2))
    joint = random.standard_normal((rows, 5, 2))
    return points, ishigami(points)[..., None] + noise * (surface + 0.2 * joint)


@pytest.fixture(scope="module")
def repeated():
    return [variance_indices(*noisy(number), (0, 0, 0)) for number in range(200)]


def test_on_average_indices_are_those_of_the_function_whatever_the_noise(repeated):
    first = np.mean([each.first for each in repeated], axis=0)
    total = np.mean([each.total for each in repeated], axis=0)
    # ratios of means are off by what 64 rows leave of a bias
    assert np.abs(first - FIRST).max() < 0.03
    assert np.abs(total - TOTAL).max() < 0.03


def test_95_percent_intervals_cover_the_truth_as_often(repeated):
    for found, error, truth in (("first", "first_error", FIRST), ("total", "total_error", TOTAL)):
        off = np.array([getattr(each, found) - truth for each in repeated])
        errors = np.array([getattr(each, error) for each in repeated])
        covered = (np.abs(off) < 1.96 * errors).mean(axis=0)
        assert (covered > 0.88).all(), covered


def test_the_surfaces_share_is_their_part_of_a_joints_variance(repeated):
    noise = 1.5**2 * 1.04
    share = np.mean([each.surfaces for each in repeated])
    assert share == pytest.approx(noise / (noise + _WHOLE), rel=0.03)


@pytest.mark.parametrize("count", [0, 2])
def test_a_quadratic_has_its_indices_to_the_last_digits(count):
    """Also where the first input has two values, of the same variance as a uniform one."""
    points = sampled_rows(3, 32, 1)
    t = 2.0 * points - 1.0
    t[..., 0] = t[..., 0] if count == 0 else np.sign(t[..., 0]) / np.sqrt(3.0)
    response = t[..., 0] + 2.0 * t[..., 1] + 3.0 * t[..., 0] * t[..., 1]
    found = variance_indices(points, np.stack([response] * 2, axis=-1), (count, 0, 0))
    parts = np.array([1.0 / 3.0, 4.0 / 3.0, 1.0])
    assert found.variance == pytest.approx(parts.sum())
    np.testing.assert_allclose(found.first, [*parts[:2] / parts.sum(), 0.0], atol=1e-12)
    totals = np.array([parts[0] + parts[2], parts[1] + parts[2], 0.0])
    np.testing.assert_allclose(found.total, totals / parts.sum(), atol=1e-12)


def test_shapley_effects_of_dependent_normals_are_those_of_the_literature():
    """Owen and Prieur (2017), Sec. 4.1: x + y of correlation r share equally; a x + b y do not."""
    points = sampled_rows(2, 256, 4)[:, 0]
    t = 2.0 * points - 1.0
    equal = fit_function(points, t[:, 0] + t[:, 1], (0, 0))
    np.testing.assert_allclose(
        shapley_effects((0, 0), equal.coefficients, {(0, 1): 0.8}), 0.5, atol=0.01
    )
    idle = fit_function(points, t[:, 0], (0, 0))
    r = 0.8
    # what knows nothing but is correlated: half of the variance that it explains
    expected = r**2 / 2.0
    found = shapley_effects((0, 0), idle.coefficients, {(0, 1): r})
    assert found.sum() == pytest.approx(1.0)
    assert found[1] == pytest.approx(expected, abs=0.02)


def test_shapley_effects_of_many_inputs_are_those_of_the_definition():
    """Some inputs dependent, some not, one of a few values: over all subsets, one by one."""
    values, correlations = (0, 3, 0, 0), {(0, 2): 0.6}
    random = np.random.default_rng(5)
    coefficients = random.standard_normal(len(terms_of(values)))
    found = shapley_effects(values, coefficients, correlations, draws=2**15)
    assert found.sum() == pytest.approx(1.0)
    defined = _shapley_values(
        range(4), values, range(len(coefficients)), coefficients, correlations, draws=2**15
    )
    np.testing.assert_allclose(found, defined / defined.sum(), atol=0.02)
    assert np.abs(found - shapley_effects(values, coefficients)).max() > 0.05


def test_what_has_no_index_is_said():
    points, responses = noisy(1, rows=16)
    with pytest.raises(jc.InputError, match=r"15 rows|must be 16 or more"):
        variance_indices(points[:15], responses[:15], (0, 0, 0))
    with pytest.raises(jc.InputError, match="must be finite"):
        variance_indices(points, responses * np.nan, (0, 0, 0))
    with pytest.raises(jc.InputError, match=r"must be \(N, d \+ 2, d\)"):
        variance_indices(points, responses[:, 1:], (0, 0, 0))
    with pytest.raises(jc.InputError, match="correlations"):
        shapley_effects((0, 0), np.ones(8), {(0, 1): 1.0})
    flat = variance_indices(points, np.ones_like(responses), (0, 0, 0))
    assert np.isnan(flat.first).all()


def test_points_at_the_end_of_an_input_of_few_values_have_its_last_one():
    assert level_of([0.0, 0.33, 0.34, 0.999, 1.0], 3).tolist() == [0, 0, 1, 2, 2]
    coefficients = np.ones(len(terms_of((3,))))
    assert np.isfinite(design_matrix(np.array([[1.0]]), (3,), terms_of((3,))) @ coefficients).all()


def test_indices_of_rows_are_fitted_without_them():
    """Of pure noise a fit to the same rows would explain a part of its own."""
    random, found = np.random.default_rng(3), []
    for number in range(60):
        points = sampled_rows(3, 16, number)
        noise = random.standard_normal((16, 5, 2))
        found.append(variance_indices(points, noise, (0, 0, 0)))
    below = [one.variance for one in found]
    assert min(below) == 0.0  # below the noise: no share of nothing
    for one in found:
        shares = np.concatenate([one.first, one.total, [one.fit_share]])
        assert np.isfinite(shares).all() == (one.variance > 0.0)
        assert np.isnan(shares).all() == (one.variance == 0.0)
    assert 0.2 < np.mean([variance == 0.0 for variance in below]) < 0.8


def test_many_fitted_functions_explain_nothing_of_the_noise_of_other_rows():
    """Fitted to the rows themselves, they would find a variance above 0 in three of four noises."""
    random = np.random.default_rng(3)
    above = 0
    for number in range(60):
        noise = random.standard_normal((16, 5, 2))
        above += variance_indices(sampled_rows(3, 16, number), noise, (4, 4, 4)).variance > 0.0
    assert above <= 30

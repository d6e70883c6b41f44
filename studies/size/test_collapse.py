"""Powers are found, and what they remove is judged by surfaces that were not fitted."""

import numpy as np
import pytest

from studies.size.study import centred, collapse_of, spreads


def made_up(surfaces, noise, power=0.7, extra=0.0, seed=1):
    """A response that goes as a power of a size, with a part that does not, on many surfaces."""
    random = np.random.default_rng(seed)
    size = np.log(np.repeat([1.0, 2.0, 4.0], 3))
    other = np.tile([-1.0, 2.0, -1.0], 3)
    own = random.standard_normal(surfaces)  # what a surface has at all conditions
    scatter = noise * random.standard_normal((9, surfaces))
    response = (power * size + extra * other)[:, None] + own + scatter
    groups = np.zeros(9)
    predictor = np.broadcast_to(size[:, None], response.shape)[np.newaxis]
    return centred(predictor, groups), centred(response, groups)


def test_a_power_is_found_and_removes_all_the_spread():
    found = collapse_of(*made_up(8, 1e-9))
    assert found.exponents == pytest.approx([0.7])
    assert found.removed == pytest.approx(1.0)
    assert found.left < 1e-8


def test_a_size_that_means_nothing_removes_nothing_of_surfaces_not_fitted():
    removed = []
    for seed in range(40):
        random = np.random.default_rng(100 + seed)
        predictors, response = made_up(8, 0.05, power=0.0, extra=0.1, seed=seed)
        noise = centred(random.standard_normal((5, *response.shape)), np.zeros(9))
        before, after = spreads(np.concatenate([predictors, noise]), response)
        removed.append(1.0 - after / before)
    mean, error = np.mean(removed), np.std(removed) / np.sqrt(len(removed))
    assert mean < 2.0 * error
    assert mean > -0.2


def test_errors_of_the_exponent_cover_it():
    held = []
    for seed in range(60):
        found = collapse_of(*made_up(8, 0.2, seed=seed))
        held.append(abs(found.exponents[0] - 0.7) < 2.36 * found.errors[0])  # t of 7 degrees
    assert np.mean(held) > 0.85


def test_the_spread_is_free_of_the_noise_of_its_means():
    squares = [spreads(*made_up(8, 0.5, power=0.3, seed=seed))[0] for seed in range(200)]
    true = np.mean((0.3 * np.log([0.5, 1.0, 2.0])) ** 2)
    error = np.std(squares) / np.sqrt(len(squares))
    assert abs(np.mean(squares) - true) < 3.0 * error
    assert true > 3.0 * error


def test_what_is_no_power_of_the_size_stays():
    predictors, response = made_up(8, 1e-9, extra=0.1)
    found = collapse_of(predictors, response)
    assert found.left == pytest.approx(np.sqrt(np.mean([0.01, 0.04, 0.01])))
    assert found.removed == pytest.approx(1.0 - 0.02 / np.mean(response[:, 0] ** 2))

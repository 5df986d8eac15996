"""Functions drawn from the process have its mean and its uncertainty."""

import numpy as np

from abradem.learning.physical import posterior_draws
from abradem.learning.physical.gaussian_process import CONSTANT, GaussianProcess, _matern
from abradem.learning.physical.posterior_draws import FunctionDraw


def fitted_process(n=50):
    rng = np.random.default_rng(0)
    x = rng.uniform(-1.0, 1.0, (n, 3))
    target = np.sin(2.0 * x[:, 0]) + 0.5 * x[:, 1] + 0.05 * rng.standard_normal(n)
    return GaussianProcess().fit(x, target, np.full(n, 0.01))


def test_draws_scatter_about_the_mean_as_the_process_is_uncertain():
    process = fitted_process()
    new = np.random.default_rng(1).uniform(-1.5, 1.5, (40, 3))
    drawn = np.array(
        [FunctionDraw(process, np.random.default_rng([2, k])).predict(new) for k in range(400)]
    )
    mean, deviation = process.predict_with_deviation(new)
    function = np.sqrt(deviation**2 - process.noise**2 - process.typical_error**2)
    # 400 draws know their mean to 5 % and their deviation to 4 % of the deviation.
    assert (np.abs(drawn.mean(axis=0) - mean) < 4.5 * function / np.sqrt(400)).all()
    ratio = drawn.std(axis=0) / function
    assert 0.8 < ratio.min() and ratio.max() < 1.25


def test_the_cosines_have_the_covariance_of_the_process(monkeypatch):
    monkeypatch.setattr(posterior_draws, "COSINES", 20_000)
    process = fitted_process()
    draw = FunctionDraw(process, np.random.default_rng(3))
    z = np.random.default_rng(4).standard_normal((6, 3))
    waves = np.cos(z @ draw._frequencies + draw._phases)
    found = 2.0 * process.smooth**2 * (waves @ waves.T) / waves.shape[1]
    exact = process.smooth**2 * _matern(z / process.lengths, z / process.lengths)[0]
    np.testing.assert_allclose(found, exact, atol=0.05 * process.smooth**2)


def test_the_prior_of_the_trends_is_that_of_the_process(monkeypatch):
    monkeypatch.setattr(posterior_draws, "COSINES", 1)
    process = fitted_process()
    z = np.random.default_rng(5).standard_normal((4, 3))
    process.smooth = 0.0
    drawn = np.array(
        [FunctionDraw(process, np.random.default_rng([6, k]))._prior(z) for k in range(4000)]
    )
    product = z @ z.T
    exact = CONSTANT + process.trend**2 * product + 0.5 * process.curvature**2 * product**2
    np.testing.assert_allclose(np.cov(drawn.T), exact, rtol=0.1)

"""The Gaussian process compared with scikit-learn, finite differences and plain leave-one-out."""

import numpy as np
import pytest
from scipy.optimize import check_grad

from abradem.learning.physical import gaussian_process as gp
from abradem.learning.physical.gaussian_process import GaussianProcess


def rows(n=60, p=3, noise=0.05, seed=0):
    rng = np.random.default_rng(seed)
    x = rng.uniform(-1.0, 1.0, (n, p))
    target = np.sin(2.0 * x[:, 0]) + 0.5 * x[:, 1] + noise * rng.standard_normal(n)
    return x, target, np.full(n, 0.01)


def test_the_gradient_is_that_of_the_loss():
    rng = np.random.default_rng(0)
    z, t = rng.standard_normal((30, 3)), rng.standard_normal(30)
    theta = np.array([0.9, 1.3, 0.5, -0.4, -2.0, -1.5, -1.0, 0.3, -0.2])
    args = (z, t, 1.0 + rng.random(30), 0.01 * rng.random(30), rng.standard_normal((30, 2)))
    away = check_grad(lambda p: gp._loss(p, *args)[0], lambda p: gp._loss(p, *args)[1], theta)
    assert away < 1e-3 * np.linalg.norm(gp._loss(theta, *args)[1])


def test_mean_and_deviation_are_those_of_scikit_learn():
    from sklearn.gaussian_process import GaussianProcessRegressor
    from sklearn.gaussian_process.kernels import (
        ConstantKernel,
        DotProduct,
        Exponentiation,
        Matern,
    )

    x, target, error = rows()
    ours = GaussianProcess().fit(x, target, error)
    z = (x - x.mean(axis=0)) / x.std(axis=0)
    kernel = (
        ConstantKernel(ours.smooth**2, "fixed") * Matern(ours.lengths, "fixed", nu=2.5)
        + ConstantKernel(ours.trend**2, "fixed") * DotProduct(0.0, "fixed")
        + ConstantKernel(0.5 * ours.curvature**2, "fixed")
        * Exponentiation(DotProduct(0.0, "fixed"), 2.0)
        + ConstantKernel(gp.CONSTANT, "fixed")
    )
    noise = ours.noise**2 / ours.weights + error**2 + gp.LEAST_ERROR**2
    theirs = GaussianProcessRegressor(kernel, alpha=noise, optimizer=None)
    theirs.fit(z, target - target.mean())
    new = np.random.default_rng(1).uniform(-1.5, 1.5, (20, 3))
    mean, deviation = ours.predict_with_deviation(new)
    expected, spread = theirs.predict((new - x.mean(axis=0)) / x.std(axis=0), return_std=True)
    np.testing.assert_allclose(mean, expected + target.mean(), rtol=1e-6, atol=1e-6)
    whole = np.sqrt(spread**2 + ours.noise**2 + ours.typical_error**2)
    np.testing.assert_allclose(deviation, whole, rtol=1e-5)


def test_leave_one_out_residuals_are_those_of_leaving_out():
    x, target, error = rows(25)
    process = GaussianProcess().fit(x, target, error)
    t = target - target.mean()
    z = process.rows
    matern, _ = gp._matern(z / process.lengths, z / process.lengths)
    covariance = process.smooth**2 * matern + process._trends(z @ z.T) + gp.CONSTANT
    noisy = covariance + np.diag(process.row_variance)
    for row in (0, 7, 24):
        kept = np.arange(len(t)) != row
        solved = np.linalg.solve(noisy[np.ix_(kept, kept)], t[kept])
        assert process.residuals[row] == pytest.approx(
            t[row] - covariance[row, kept] @ solved, abs=1e-7
        )


def test_an_outlying_row_is_found_and_does_no_harm():
    x, target, error = rows(80)
    clean = GaussianProcess().fit(x, target, error)
    bad = target.copy()
    bad[5] += 2.0
    process = GaussianProcess().fit(x, bad, error)
    assert np.argmin(process.weights) == 5 and process.weights[5] < 0.1
    # A low weight must not increase the predicted deviation, on which intervals are calibrated.
    assert process.deviations[5] < 2.0 * np.median(process.deviations)
    new = np.random.default_rng(1).uniform(-1.0, 1.0, (200, 3))
    assert np.abs(process.predict(new) - clean.predict(new)).max() < 0.15


def test_a_feature_that_does_nothing_gets_the_longest_length():
    x, target, error = rows(120)
    process = GaussianProcess().fit(x, target, error)
    assert process.lengths[0] < process.lengths[1] and process.lengths[0] < process.lengths[2]


def test_deviations_are_wider_away_from_the_rows():
    x, target, error = rows()
    process = GaussianProcess().fit(x, target, error)
    _, near = process.predict_with_deviation(np.zeros((1, 3)))
    _, far = process.predict_with_deviation(np.full((1, 3), 4.0))
    assert far[0] > 3.0 * near[0]


def test_a_process_survives_its_file(tmp_path):
    from abradem.store.files import read_arrays, write_arrays

    x, target, error = rows()
    for terms in (None, lambda found: found[:, :2]):
        process = GaussianProcess(0, terms).fit(x, target, error)
        write_arrays(process.arrays(), tmp_path / "p.safetensors")
        again = GaussianProcess.of(read_arrays(tmp_path / "p.safetensors"), terms)
        for a, b in zip(
            process.predict_with_deviation(x), again.predict_with_deviation(x), strict=True
        ):
            np.testing.assert_array_equal(a, b)


def noisy_rows(n=200, seed=0):
    """Rows whose noise grows with the third feature, by the factor 9 from end to end."""
    x, target, error = rows(n, noise=0.0, seed=seed)
    noise = 0.05 * np.exp(1.1 * x[:, 2])
    return x, target + noise * np.random.default_rng(seed + 1).standard_normal(n), error, noise


def test_the_local_noise_of_a_process_is_that_of_the_rows():
    x, target, error, noise = noisy_rows()
    of_last = lambda found: found[:, 2:]  # noqa: E731
    local = GaussianProcess(0, of_last).fit(x, target, error)
    found = local.noise * np.exp(local._of_noise.forward(of_last(x)) @ local.noise_slopes)
    # The prior holds the slope back a little.
    np.testing.assert_allclose(found, noise, rtol=0.35)
    one = GaussianProcess(0).fit(x, target, error)
    new = np.random.default_rng(5).uniform(-1.0, 1.0, (500, 3))
    true = np.sin(2.0 * new[:, 0]) + 0.5 * new[:, 1]
    errors = [np.mean((process.predict(new) - true) ** 2) for process in (local, one)]
    assert errors[0] < 0.8 * errors[1]
    _, deviation = local.predict_with_deviation(new)
    steep, flat = deviation[new[:, 2] > 0.5], deviation[new[:, 2] < -0.5]
    assert np.median(steep) > 2.5 * np.median(flat)


def test_repeated_rows_without_errors_or_noise_do_no_harm():
    rng = np.random.default_rng(4)
    x = np.repeat(rng.uniform(-1.0, 1.0, (40, 3)), 3, axis=0)
    target = np.sin(2.0 * x[:, 0])
    for noise_terms in (None, lambda found: found[:, 1:]):
        process = GaussianProcess(0, noise_terms).fit(x, target, np.zeros(120))
        assert np.abs(process.predict(x) - target).max() < 0.01


def test_a_second_order_law_is_learned_beyond_the_rows():
    rng = np.random.default_rng(0)
    x = rng.uniform(-1.0, 1.0, (80, 3))
    law = lambda x: x[:, 0] + 0.7 * x[:, 1] ** 2 - 0.5 * x[:, 0] * x[:, 2]  # noqa: E731
    process = GaussianProcess().fit(x, law(x), np.full(80, 0.01))
    new = rng.uniform(-1.4, 1.4, (200, 3))
    assert np.abs(process.predict(new) - law(new)).max() < 0.05


def test_many_rows_are_thinned_and_blocks_change_nothing(monkeypatch):
    x, target, error = rows(300, noise=0.01)
    monkeypatch.setattr(gp, "MOST_ROWS", 200)
    process = GaussianProcess().fit(x, target, error)
    assert len(process.weights) == 200
    assert np.abs(process.predict(x) - target).mean() < 0.03
    joined = np.concatenate([k for k, _ in process.blocks(x, size=7)])
    np.testing.assert_allclose(joined, next(process.blocks(x))[0], atol=1e-12)


def test_the_same_seed_gives_the_same_process():
    x, target, error = rows()
    one, two = (GaussianProcess(3).fit(x, target, error) for _ in range(2))
    np.testing.assert_array_equal(one.predict(x), two.predict(x))

"""The transient is found and the error of the rate is honest, on series whose truth is known."""

import numpy as np
import pytest

from abradem.dem.steady import batch_means, steady_start


def series(rng, rate=100.0, until=20.0, transient=0.0, interval=0.02, correlation=0.0):
    """Cumulative series: compound Poisson increments, ramped up during the transient."""
    time = np.arange(0.0, until + interval / 2, interval)
    middle = 0.5 * (time[1:] + time[:-1])
    ramp = np.clip(middle / transient, 0.0, 1.0) if transient else np.ones_like(middle)
    counts = rng.poisson(rate * interval * ramp)
    increments = np.array([rng.exponential(1.0, n).sum() for n in counts])
    if correlation:
        noise = np.zeros(increments.size)
        for i in range(1, noise.size):
            noise[i] = correlation * noise[i - 1] + rng.normal()
        increments += 2.0 * noise
    return time, np.concatenate([[0.0], np.cumsum(increments)])


def test_a_ramp_is_dropped_and_a_steady_series_kept():
    rng = np.random.default_rng(1)
    starts = [steady_start(*series(rng, rate=3000.0, transient=3.0)) for _ in range(40)]
    assert 1.5 < np.median([s.time for s in starts]) < 5.0
    assert np.mean([s.settled for s in starts]) > 0.9
    kept = [steady_start(*series(rng)).time for _ in range(40)]
    assert np.median(kept) < 2.0


def test_a_dead_time_before_the_first_wear_is_dropped():
    time, worn = series(np.random.default_rng(2))
    late = np.concatenate([time, time[-1] + time[1:]])
    shifted = np.concatenate([np.zeros(time.size - 1), worn])
    assert steady_start(late, np.append(shifted, shifted[-1])[: late.size]).time >= time[-1] - 0.1


def test_a_drifting_series_is_not_called_settled():
    time = np.linspace(0.0, 20.0, 1001)
    assert not steady_start(time, time**2).settled
    assert not steady_start(time, np.zeros_like(time)).settled


def test_batch_means_recover_the_rate():
    time, worn = series(np.random.default_rng(3), until=200.0)
    means = batch_means(time, worn, 0.0)
    assert means.rate == pytest.approx(worn[-1] / 200.0, rel=1e-12)
    assert means.rate == pytest.approx(100.0, abs=4.0 * means.stderr)
    # Compound Poisson: the variance of the sum is rate * time * E[x^2].
    assert means.stderr == pytest.approx(np.sqrt(100.0 * 2.0 / 200.0), rel=0.35)


@pytest.mark.parametrize("correlation", [0.0, 0.95])
def test_intervals_of_batch_means_cover_the_truth(correlation):
    from scipy.stats import binom, t

    rng = np.random.default_rng(4)
    count, factor = 200, t.ppf(0.975, 19)
    covered = 0
    for _ in range(count):
        means = batch_means(*series(rng, until=10.0, correlation=correlation), 0.0)
        covered += abs(means.rate - 100.0) <= factor * means.stderr
    low = binom.ppf(0.001, count, 0.95 if correlation == 0 else 0.90)
    assert covered >= low


def test_correlated_batches_are_seen_and_the_error_enlarged():
    rng = np.random.default_rng(5)
    time = np.linspace(0.0, 20.0, 1001)
    wave = np.cumsum(100.0 + 30.0 * np.sin(0.6 * time[1:]) + rng.normal(0, 1, 1000)) * 0.02
    means = batch_means(time, np.concatenate([[0.0], wave]), 0.0)
    assert means.lag1 > 0.4
    plain = np.diff(np.interp(np.linspace(0, 20, 21), time, np.concatenate([[0.0], wave])))
    assert means.stderr > 1.5 * plain.std(ddof=1) / np.sqrt(20)


def test_too_short_a_series_has_no_error():
    time, worn = series(np.random.default_rng(6), until=0.2)
    assert np.isnan(batch_means(time, worn, 0.0).stderr)

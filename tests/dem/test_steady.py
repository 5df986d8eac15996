"""The transient is found and the error of the rate is honest, on series whose truth is known."""

import numpy as np
import pytest

from abradem.dem.steady import (
    LARGEST_CHANGE,
    batch_means,
    change,
    integral,
    steady_part,
    steady_start,
)


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


def bed(rng, until, filled=9.0, empty=400.0, full=750.0, shielded=0.5):
    """Record of a bed that fills until ``filled``, slowly at first, and shields the plate."""
    time, worn = series(rng, rate=3000.0, until=until)
    share = np.clip(time / filled, 0.0, 1.0) ** 2
    present = empty + (full - empty) * share + 10.0 * np.sin(3.0 * time)
    slower = 1.0 - shielded * share
    return time, integral(time, np.gradient(worn, time) * slower), np.round(present)


def test_a_bed_that_fills_is_not_steady_before_it_is_full():
    rng = np.random.default_rng(7)
    filling = [steady_part(*bed(rng, 6.0), 5.5) for _ in range(40)]
    assert not any(part.settled for part in filling)
    full = [steady_part(*bed(rng, 24.0), 5.5) for _ in range(40)]
    assert all(part.settled for part in full)
    assert 7.0 < min(part.time for part in full) and max(part.time for part in full) < 12.0


def test_particles_present_show_what_the_wear_hides():
    # The wear alone, of a bed that fills but does not shield yet, is steady.
    time, worn, present = bed(np.random.default_rng(8), 8.0, filled=8.0, shielded=0.0)
    assert steady_start(time, worn, 5.5).settled
    assert not steady_part(time, worn, present, 5.5).settled
    assert steady_part(time, worn, np.full(time.size, 400), 5.5) == steady_start(time, worn, 5.5)


def test_a_few_large_stones_are_steady():
    # A jet of 2 stones in the air on average: Poisson, so their number changes by chance alone.
    rng = np.random.default_rng(9)
    time, worn = series(rng)
    parts = []
    for _ in range(100):
        present = np.repeat(rng.poisson(2.0, time.size // 20 + 1), 20)[: time.size]
        parts.append(steady_part(time, worn, present, 5.5).settled)
    assert np.mean(parts) > 0.9


def test_nothing_present_is_steady():
    time, worn = series(np.random.default_rng(10))
    assert steady_part(time, worn, np.zeros(time.size), 5.5) == steady_start(time, worn, 5.5)


def test_a_late_transient_is_found_while_the_window_remains():
    time = np.arange(0.0, 20.01, 0.02)
    level = np.where(time < 12.0, 3.0 - time / 6.0, 1.0)
    worn = integral(time, level + 0.02 * np.random.default_rng(11).normal(size=time.size))
    assert not steady_start(time, worn).settled
    found = steady_start(time, worn, 5.5)
    assert found.settled and found.time == pytest.approx(12.0, abs=0.5)
    # No window of 9 s is left after 12 s.
    late = steady_start(time, worn, 9.0)
    assert not late.settled and late.time == pytest.approx(10.0, abs=0.11)


def test_a_drop_after_the_half_is_no_steady_state():
    # The truncation rule alone does not see it: dropping half of the record gains nothing.
    time = np.arange(0.0, 10.01, 0.02)
    noise = np.random.default_rng(15).normal(size=time.size)
    worn = integral(time, np.where(time < 7.0, 2.0, 1.0) + 0.1 * noise)
    constant = np.full(time.size, 400)
    assert steady_start(time, worn, 5.5).settled
    assert not steady_part(time, worn, constant, 5.5).settled
    plain = integral(time, 2.0 + 0.1 * noise)
    assert steady_part(time, plain, constant, 5.5) == steady_start(time, plain, 5.5)


def test_the_integral_is_exact_for_a_straight_line():
    time = np.sort(np.random.default_rng(12).random(50))
    expected = 1.5 * (time**2 - time[0] ** 2) + 2.0 * (time - time[0])
    np.testing.assert_allclose(integral(time, 3.0 * time + 2.0), expected, rtol=0, atol=1e-14)


def test_the_change_of_a_level_is_that_of_its_line():
    time = np.linspace(0.0, 10.0, 501)
    # Batches of 5 s / 20 begin and end between samples, where the line's integral is interpolated.
    found = change(time, integral(time, 100.0 + 4.0 * time), 5.0)
    assert found.change == pytest.approx(20.0 / 130.0, rel=1e-4)
    assert found.stderr < 1e-4
    assert np.isnan(change(time, 100.0 * time, 9.9).change)
    assert np.isnan(change(time, np.zeros(time.size), 5.0).change)


def test_the_error_of_a_change_is_that_of_least_squares():
    from scipy.stats import linregress

    values = np.random.default_rng(13).normal(100.0, 5.0, 20)
    line = linregress(np.arange(20), values)
    residual = values - line.intercept - line.slope * np.arange(20)
    assert residual[1:] @ residual[:-1] < 0.0  # so that the error is not enlarged
    found = change(np.arange(21.0), np.concatenate([[0.0], np.cumsum(values)]), 0.0)
    assert found.change == pytest.approx(20.0 * line.slope / values.mean(), rel=1e-9)
    assert found.stderr == pytest.approx(20.0 * line.stderr / values.mean(), rel=1e-9)


def test_a_change_within_its_error_or_below_the_limit_is_none():
    time, worn = series(np.random.default_rng(14), rate=3000.0)
    alone = steady_start(time, worn, 5.5)
    slow = 100.0 * (1.0 + 0.8 * LARGEST_CHANGE * time / time[-1])
    assert steady_part(time, worn, slow, 5.5) == alone
    fast = 100.0 * (1.0 + 2.0 * LARGEST_CHANGE * time / time[-1])
    assert steady_part(time, worn, fast, 5.5) != alone


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

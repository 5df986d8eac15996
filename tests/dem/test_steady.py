"""The transient and the standard error of the rate are correct for series with known values."""

import numpy as np
import pytest

from abradem.dem.steady import (
    COSINES,
    LARGEST_CHANGE,
    batch_means,
    change,
    cosines,
    integral,
    slow_variance,
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
    """Series of a bed that fills until ``filled``, slowly at first, and shields the plate."""
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
    # The wear of a bed that fills but does not yet shield the plate is steady.
    time, worn, present = bed(np.random.default_rng(8), 8.0, filled=8.0, shielded=0.0)
    assert steady_start(time, worn).settled
    assert not steady_part(time, worn, present, 5.5).settled
    assert steady_part(time, worn, np.full(time.size, 400), 5.5) == steady_start(time, worn)


def test_a_few_large_particles_are_steady():
    # A jet of 2 particles in the air on average: Poisson, so their number changes by chance alone.
    rng = np.random.default_rng(9)
    time, worn = series(rng)
    parts = []
    for _ in range(100):
        present = np.repeat(rng.poisson(2.0, time.size // 20 + 1), 20)[: time.size]
        parts.append(steady_part(time, worn, present, 5.5).settled)
    assert np.mean(parts) > 0.9


@pytest.mark.parametrize("present", [0.0, np.repeat([50.0, 0.0], [100, 901])])
def test_nothing_present_is_steady(present):
    time, worn = series(np.random.default_rng(10))
    worn = np.where(time < 2.0, 0.0, worn)
    present = np.zeros(time.size) + present
    assert steady_part(time, worn, present, 5.5) == steady_start(time, worn)


def test_the_later_of_two_transients_counts():
    rng = np.random.default_rng(16)
    time, _ = series(rng)
    noise = 0.02 * rng.normal(size=(2, time.size))
    # The number of particles still changes after the wear has settled, and vice versa.
    for wear_ends, bed_ends in ((2.0, 6.0), (6.0, 4.0)):
        worn = integral(time, np.where(time < wear_ends, 3.0, 1.0) + noise[0])
        growing = np.where(time < bed_ends, 200.0, 400.0) * (1.0 + noise[1])
        found = steady_part(time, worn, growing, 5.5)
        assert found.settled
        assert found.time == pytest.approx(max(wear_ends, bed_ends), abs=0.2)
    # Still growing after the wear's transient, from a transient of their own that ended earlier.
    worn = integral(time, np.where(time < 6.0, 3.0, 1.0) + noise[0])
    slow = 300.0 + 6.0 * np.clip(time, 6.0, None) * (1.0 + noise[1])
    assert steady_part(time, worn, slow, 5.5).time >= 6.0


def test_a_late_transient_is_found_while_the_window_remains():
    time = np.arange(0.0, 20.01, 0.02)
    level = np.where(time < 12.0, 3.0 - time / 6.0, 1.0)
    worn = integral(time, level + 0.02 * np.random.default_rng(11).normal(size=time.size))
    constant = np.full(time.size, 400)
    assert not steady_start(time, worn).settled
    assert steady_start(time, worn, 14.5).time == pytest.approx(12.0, abs=0.5)
    found = steady_part(time, worn, constant, 5.5)
    assert found.settled and found.time == pytest.approx(12.0, abs=0.5)
    # No window of 9 s is left after 12 s.
    late = steady_part(time, worn, constant, 9.0)
    assert not late.settled and late.time == pytest.approx(10.0, abs=0.11)


def test_a_drop_after_the_half_is_no_steady_state():
    # The truncation rule alone does not detect it: dropping half of the series gains nothing.
    time = np.arange(0.0, 10.01, 0.02)
    noise = np.random.default_rng(15).normal(size=time.size)
    worn = integral(time, np.where(time < 7.0, 2.0, 1.0) + 0.1 * noise)
    constant = np.full(time.size, 400)
    assert steady_start(time, worn).settled
    dropped = steady_part(time, worn, constant, 5.5)
    assert not dropped.settled and dropped.time >= 5.0
    plain = integral(time, 2.0 + 0.1 * noise)
    assert steady_part(time, plain, constant, 5.5) == steady_start(time, plain)


def test_a_change_after_a_steady_half_begins_the_part_again():
    time, _ = series(np.random.default_rng(17), until=60.0)
    noise = 0.02 * np.random.default_rng(17).normal(size=time.size)
    worn = integral(time, np.where(time < 40.0, 2.0, 1.0) + noise)
    present = np.where(time < 40.0, 400, 700)
    assert steady_start(time, worn).settled and steady_start(time, worn).time < 5.0
    found = steady_part(time, worn, present, 5.5)
    assert found.settled and found.time == pytest.approx(40.0, abs=0.2)


@pytest.mark.parametrize(
    "until, window, noise", [(9.0, 5.5, 0.05), (2.6, 1.1, 0.3), (3.6, 1.1, 0.3)]
)
def test_a_late_search_is_never_shorter_than_the_half(until, window, noise):
    """A drift that the first half does not end is not ended by a shorter search."""
    time = np.arange(0.0, until + 0.01, 0.02)
    for seed in range(15):
        scatter = noise * np.random.default_rng(seed).normal(size=time.size)
        worn = integral(time, np.where(time < 0.3, 0.0, 1.0 - 0.03 * time + scatter))
        half = steady_start(time, worn)
        part = steady_part(time, worn, np.full(time.size, 400), window)
        assert part.settled <= half.settled
        if part.settled:
            assert part == half


def test_short_windows_leave_enough_to_judge_by():
    """A change in the last few bins only is not a drift."""
    time = np.arange(0.0, 9.01, 0.02)
    for seed in range(30):
        noise = 0.1 * np.random.default_rng(seed).normal(size=time.size)
        worn = integral(time, np.where(time < 0.3, 0.0, 1.0 - 0.08 * time + noise))
        assert not steady_part(time, worn, np.full(time.size, 400), 0.3).settled


@pytest.mark.parametrize("until", [0.1, 0.5, 1.06, 3.0])
def test_a_short_record_is_judged_without_error(until):
    time = np.arange(0.0, until, 0.01)
    part = steady_part(time, time**2, np.full(time.size, 40), 0.055)
    assert not part.settled and part.time <= time[-1]


def test_a_part_too_short_for_its_batches_is_not_steady():
    # 18 samples after the first wear.
    time = np.arange(0.0, 1.91, 0.1)
    worn = integral(time, np.where(time < 0.1, 0.0, 1.0))
    assert steady_start(time, worn).settled
    assert not steady_part(time, worn, np.full(time.size, 40), 5.5).settled


def test_a_constant_end_is_found_exactly():
    time = np.arange(0.0, 60.01, 0.02)
    worn = integral(time, np.where(time < 40.0, 2.0, 1.3))
    assert steady_start(time, worn, 54.5).time == pytest.approx(40.0, abs=0.11)


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


@pytest.mark.parametrize("wave", [0.0, 20.0])
def test_the_error_of_a_change_is_that_of_least_squares(wave):
    """The slope's by a parabola's residuals, enlarged where these are correlated."""
    values = np.random.default_rng(13).normal(100.0, 5.0, 20) + wave * np.sin(0.6 * np.arange(20.0))
    place = (np.arange(20) - 9.5) / 20
    design = np.stack([np.ones(20), place, place**2], axis=1)
    fit, _, _, _ = np.linalg.lstsq(design, values, rcond=None)
    residual = values - design @ fit
    lag1 = residual[1:] @ residual[:-1] / (residual @ residual)
    assert (lag1 > 0.4) if wave else (lag1 < 0.0)
    covariance = np.linalg.inv(design.T @ design) * (residual @ residual) / 17
    stderr = np.sqrt(covariance[1, 1]) / values.mean()
    if wave:
        stderr *= np.sqrt((1.0 + lag1) / (1.0 - lag1))
    found = change(np.arange(21.0), np.concatenate([[0.0], np.cumsum(values)]), 0.0)
    assert found.change == pytest.approx(fit[1] / values.mean(), rel=1e-9)
    assert found.stderr == pytest.approx(stderr, rel=1e-9)


@pytest.mark.parametrize("last", [0.3, 0.5, 0.8])
def test_a_late_growth_is_no_scatter(last):
    time = np.linspace(0.0, 10.0, 1001)
    begin = 10.0 * (1.0 - last)
    level = 400.0 * (1.0 + np.clip((time - begin) / (10.0 - begin), 0.0, 1.0) * (1.0 + last))
    found = change(time, integral(time, level), 0.0)
    assert abs(found.change) > 3.0 * found.stderr


def test_a_change_within_its_error_or_below_the_limit_is_none():
    time, worn = series(np.random.default_rng(14), rate=3000.0)
    alone = steady_start(time, worn)
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
    count = 200
    covered = 0
    for _ in range(count):
        means = batch_means(*series(rng, until=10.0, correlation=correlation), 0.0)
        covered += abs(means.rate - 100.0) <= t.ppf(0.975, means.freedom) * means.stderr
    low = binom.ppf(0.001, count, 0.95 if correlation == 0 else 0.90)
    assert covered >= low


def of_batches(means):
    """`batch_means` of a series with these rates in equal batches of 1 s, one sample each."""
    return batch_means(
        np.arange(len(means) + 1.0), np.append(0.0, np.cumsum(means)), 0.0, len(means) // 2
    )


def test_the_error_of_independent_pieces_has_no_bias():
    """The expectation of a square sum under the covariance 1 is its sum over unit vectors."""
    squares = [slow_variance(row, 12) for row in np.eye(40)]
    assert sum(squares) == pytest.approx(1.0 / 40, rel=1e-12)


def test_the_freedom_is_that_of_the_quadratic_form():
    """x'Ax of normal x has the mean tr A and the variance 2 tr A^2: freedom (tr A)^2 / tr A^2."""
    number = 40
    form = np.zeros((number, number))
    for i, one in enumerate(np.eye(number)):
        for j, two in enumerate(np.eye(number)):
            # Polarisation: the square sum of a sum less that of a difference.
            form[i, j] = 0.25 * (slow_variance(one + two, 12) - slow_variance(one - two, 12))
    assert np.trace(form) ** 2 / np.trace(form @ form) == pytest.approx(12.0, rel=1e-12)
    found = of_batches(np.random.default_rng(23).normal(size=number))
    assert found.lag1 < 0.26 and found.freedom == COSINES == 12


@pytest.mark.parametrize("pieces, number", [(20, 6), (35, 11), (36, 12), (79, 12)])
def test_few_batches_have_fewer_cosines(pieces, number):
    assert cosines(pieces) == number


def test_the_error_is_that_of_the_slowest_cosines():
    """Slow twin: a discrete cosine transform, written out as sums."""
    means = np.random.default_rng(24).normal(5.0, 1.0, 50)
    total = 0.0
    for j in range(1, 13):
        wave = [np.cos(np.pi * j * (2 * k + 1) / 100) for k in range(50)]
        norm = sum(one * one for one in wave)
        total += sum(one * x for one, x in zip(wave, means, strict=True)) ** 2 / norm
    assert of_batches(means).stderr ** 2 == pytest.approx(total / 12 / 50, rel=1e-9)


def test_what_a_batch_wears_less_at_its_edge_its_neighbour_wears_more():
    """The scatter of the edges is not that of the mean: independent batches give 1.3 times it."""
    rng = np.random.default_rng(25)
    found, plain = [], []
    for _ in range(400):
        edges = 0.6 * rng.normal(size=41)
        means = 100.0 + rng.normal(size=40) + np.diff(edges)
        found.append(of_batches(means))
        plain.append(means.std(ddof=1) / np.sqrt(40))
    true = np.sqrt(1.0 / 40 + 2.0 * 0.6**2 / 40**2)
    assert np.std([means.rate for means in found]) == pytest.approx(true, rel=0.15)
    stated = np.sqrt(np.mean([means.stderr**2 for means in found]))
    assert stated == pytest.approx(true, rel=0.08)
    assert np.mean(plain) > 1.2 * true


def test_correlated_batches_are_seen_and_the_error_enlarged():
    rng = np.random.default_rng(5)
    time = np.linspace(0.0, 20.0, 1001)
    wave = np.cumsum(100.0 + 30.0 * np.sin(0.6 * time[1:]) + rng.normal(0, 1, 1000)) * 0.02
    means = batch_means(time, np.concatenate([[0.0], wave]), 0.0)
    assert means.lag1 > 0.4
    plain = np.diff(np.interp(np.linspace(0, 20, 41), time, np.concatenate([[0.0], wave]))) / 0.5
    known = (1.0 + means.lag1) / (1.0 - means.lag1) * plain.var(ddof=1) / 38
    assert means.stderr**2 == pytest.approx(known, rel=1e-9)
    assert means.stderr > 1.5 * plain.std(ddof=1) / np.sqrt(40)


def test_too_short_a_series_has_no_error():
    time, worn = series(np.random.default_rng(6), until=0.2)
    assert np.isnan(batch_means(time, worn, 0.0).stderr)

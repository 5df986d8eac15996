"""The stop rule does not prefer records that are low by chance, and the engine follows it."""

import math

import numpy as np
import pytest
from scipy import stats

from abradem.dem import simulate
from abradem.dem.model import Setup
from abradem.dem.steady import batch_means, steady_part
from abradem.dem.stop import CHECK_GROWTH, PARTICLES, WELL_BELOW, StopRule
from abradem.verification.jets import JET, jet_case

INTERVAL = 0.02
FEED = 40.0
"""Particles per second of the synthetic jets."""


def jet(rng, spread, until=60.0, memory=0.0):
    """Samples of a jet of rate `FEED`: each particle wears 1 on average, with this spread.

    ``memory`` is the correlation of the logarithm of the wear of one particle with the next.
    """
    number = int(FEED * until)
    deviation = rng.normal(size=number)
    for i in range(1, number):
        deviation[i] = memory * deviation[i - 1] + math.sqrt(1.0 - memory**2) * deviation[i]
    worn = np.exp(spread * deviation - 0.5 * spread**2)
    time = np.arange(int(until / INTERVAL) + 1) * INTERVAL
    impacts = np.searchsorted(time, (np.arange(number) + 0.5) / FEED)
    summed = np.zeros(time.size)
    np.add.at(summed, impacts, worn)
    return time, np.cumsum(summed), np.full(time.size, 10)


def ended(setup, record, interval=1.0 / FEED):
    """Steady part at the end by the rule, and the sample of that end."""
    rule = StopRule(setup, INTERVAL, interval)
    while rule.next_look < len(record[0]):
        past = [values[: rule.next_look + 1] for values in record]
        if rule.ends(*past):
            return rule.steady(*past), len(past[0]) - 1
    return rule.steady(*record), len(record[0]) - 1


def coverage(rule, records):
    """Share of the 95 % intervals that hold the rate, and mean error in standard errors."""
    held, off = [], []
    for record in records:
        rate, stderr, freedom = rule(record)
        held.append(abs(rate - FEED) <= stats.t.ppf(0.975, freedom) * stderr)
        off.append((rate - FEED) / FEED)
    return np.mean(held), np.mean(off)


def by_the_rule(record):
    part, _ = ended(Setup(), record)
    return part.rate, part.relative_stderr * part.rate, part.freedom


def by_the_first_small_error(record):
    """The rule without its conditions: the first look with a whole window and a small error."""
    rule = StopRule(Setup(), INTERVAL, 1.0 / FEED)
    sample = rule.next_look
    while sample < len(record[0]):
        past = [values[: sample + 1] for values in record]
        part = rule.steady(*past)
        complete = part.settled and past[0][-1] >= part.window_end
        if complete and part.relative_stderr <= rule.target:
            break
        sample = math.ceil(CHECK_GROWTH * sample)
    return part.rate, part.relative_stderr * part.rate, part.freedom


def test_intervals_hold_as_often_as_stated_for_correlated_wear():
    """Binomial band of 200 records; a correlation over a few particles is inside a batch."""
    rng = np.random.default_rng(5)
    records = [jet(rng, 0.35, memory=0.6) for _ in range(200)]
    held, off = coverage(by_the_rule, records)
    low, high = stats.binom.ppf([0.001, 0.999], 200, 0.95) / 200
    assert low <= held <= high
    assert abs(off) < 3.3 * 0.02 / math.sqrt(200)


def test_intervals_hold_as_often_as_stated_for_white_wear():
    rng = np.random.default_rng(6)
    held, off = coverage(by_the_rule, [jet(rng, 0.5) for _ in range(300)])
    low, high = stats.binom.ppf([0.025, 0.999], 300, 0.95) / 300
    assert low <= held <= high
    assert abs(off) < 3.3 * 0.02 / math.sqrt(300)


def test_the_first_small_error_prefers_records_without_the_rare_particles_that_wear_most():
    """One particle in a hundred wears five times as much: the rule is less often misled."""
    rng = np.random.default_rng(6)
    records = []
    for _ in range(200):
        time, worn, present = jet(rng, 0.1)
        increments = np.diff(worn, prepend=0.0)
        increments[rng.random(time.size) < 0.01] *= 5.0
        records.append((time, np.cumsum(increments) / 1.04, present))
    first, first_off = coverage(by_the_first_small_error, records)
    held, off = coverage(by_the_rule, records)
    assert first + 0.05 < held
    assert first_off < off - 0.002 < 0.0


def test_evenly_released_particles_are_no_scatter():
    """All particles wear the same: the error is zero, whatever the edges of the batches."""
    time, worn, _ = jet(np.random.default_rng(7), 0.0, until=20.0)
    slow = FEED / 8.0
    impacts = np.searchsorted(time, (np.arange(int(20.0 * slow)) + 0.5) / slow)
    worn = np.zeros(time.size)
    worn[impacts] = 1.0
    worn = np.cumsum(worn)
    for samples in (301, 443, 777, 1001):
        plain = batch_means(time[:samples], worn[:samples], 0.5)
        whole = batch_means(time[:samples], worn[:samples], 0.5, release_interval=1.0 / slow)
        assert whole.rate == pytest.approx(slow, rel=1e-9)
        assert whole.stderr < 1e-9 < 0.005 * plain.rate < plain.stderr
        assert 20 <= whole.batches < 80


def test_too_few_releases_are_divided_as_if_they_were_not_even():
    time, worn, _ = jet(np.random.default_rng(8), 0.5, until=10.0)
    assert batch_means(time, worn, 0.5, release_interval=0.5) == batch_means(time, worn, 0.5)


def test_a_case_ends_after_enough_particles_or_at_once_if_few_are_enough():
    record = jet(np.random.default_rng(9), 0.05)
    part, sample = ended(Setup(target_stderr=0.02), record)
    released = FEED * (record[0][sample] - part.start)
    assert PARTICLES / 0.02**2 <= released < CHECK_GROWTH * PARTICLES / 0.02**2 + FEED * 0.1
    # A fixed window is a target that any record meets: it ends with its window.
    part, sample = ended(Setup(target_stderr=0.5, window=3.0), record)
    assert record[0][sample] == pytest.approx(part.window_end)


def test_two_looks_in_a_row_are_asked_for_unless_the_error_is_well_below():
    setup = Setup(target_stderr=0.02)
    rng = np.random.default_rng(10)
    records = [jet(rng, 0.5) for _ in range(60)]
    once = 0
    for record in records:
        rule, small = StopRule(setup, INTERVAL, 1.0 / FEED), []
        while True:
            past = [values[: rule.next_look + 1] for values in record]
            ends = rule.ends(*past)
            small.append(rule.steady(*past).relative_stderr)
            if ends:
                break
        assert small[-1] <= setup.target_stderr
        if len(small) > 1 and small[-2] > setup.target_stderr:
            assert small[-1] <= WELL_BELOW * setup.target_stderr
        once += sum(error <= setup.target_stderr for error in small[:-1])
    # Without the second look these would have ended earlier.
    assert once > 10


def slow_twin(result, setup):
    """Sample at which the written rule ends a longer record of the case."""
    interval = result.time[1]
    per_map = round(setup.window / 10 / interval)
    look, small_before = math.ceil(setup.window / interval - 1e-9), False
    for k in range(1, len(result.time)):
        if k < look:
            continue
        time, worn, present = result.time[: k + 1], result.worn[: k + 1, 0], result.present[: k + 1]
        begun = steady_part(time, worn, present, 11 * per_map * interval)
        first = math.ceil(begun.time / (per_map * interval) - 1e-9)
        found = batch_means(
            time, worn, first * per_map * interval, release_interval=result.release_interval
        )
        small = False
        look = max(k + 1, math.ceil(1.1 * k - 1e-9))
        if not begun.settled:
            look = min(look, k + per_map)
        elif k < (first + 10) * per_map:
            look = min(look, (first + 10) * per_map)
        else:
            small = found.stderr <= setup.target_stderr * found.rate
            particles = (time[-1] - first * per_map * interval) / result.release_interval
            enough = particles >= 0.12 / setup.target_stderr**2
            well = found.stderr <= 0.67 * setup.target_stderr * found.rate
            if small and enough and (small_before or well):
                return k
        small_before = small
    return None


@pytest.mark.parametrize("target", [0.15, 0.05])
@pytest.mark.parametrize("angle", [5.0, 60.0])
def test_the_engine_ends_where_the_written_rule_does(target, angle):
    setup = JET.setup(window=2.0, max_time=40.0, target_stderr=target)
    case = jet_case(plate_angle=angle, particle_radius=0.03)
    result = simulate(case, setup)
    alone = simulate(case, setup, progress=lambda time: None)
    assert result.simulated_time == alone.simulated_time < 39.0
    longer = simulate(case, JET.setup(window=2.0, duration=40.0))
    assert slow_twin(longer, setup) == len(result.time) - 1
    assert np.array_equal(longer.worn[: len(result.time)], result.worn)


def test_a_crowd_with_a_fixed_window_ends_as_soon_as_it_is_complete():
    """At the first look at which the window after the transient is complete."""
    setup = JET.setup(window=1.0, max_time=10.0, target_stderr=0.5)
    result = simulate(jet_case(plate_angle=50.0, particle_radius=0.012), setup)
    assert result.settled and result.simulated_time < 2.0
    rule = StopRule(setup, result.time[1], result.release_interval)
    looks = []
    while rule.next_look < len(result.time):
        past = slice(rule.next_look + 1)
        record = (result.time[past], result.worn[past, 0], result.present[past])
        ends = rule.ends(*record)
        looks.append((rule.steady(*record).window_end <= record[0][-1] + 1e-9, ends))
    assert looks[-1] == (True, True) and set(looks[:-1]) <= {(False, False)}

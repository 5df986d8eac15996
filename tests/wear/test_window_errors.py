"""Standard errors of the statistics over elements: closed forms, slow twins, replicates."""

import itertools
import math

import numpy as np
import pandas as pd
import pytest

from abradem.dem.model import Setup
from abradem.quantities import (
    SAMPLED,
    STATISTICS,
    STDERR_COLUMNS,
    WEAR_COLUMNS,
    stderr_column,
    wear_column,
)
from abradem.simulation.batch import TABLES, run_case
from abradem.wear.rates import element_rates, wear_rates
from abradem.wear.window_errors import element_stderr, subset_statistics

OVER_ELEMENTS = STATISTICS[1:]


def gamma_parts(rng, parts, shape, mean=4.0):
    """Work of elements in parts: independent gamma variables of variance ``mean``."""
    return rng.gamma(mean, 1.0, (parts, *shape))


@pytest.mark.parametrize("count", [1, 2, 30, 99, 100, 101, 102, 900])
@pytest.mark.parametrize("touched", [0.0, 0.02, 0.5, 1.0])
@pytest.mark.parametrize("share", [0.5, 0.95, 1.0])
def test_statistics_of_many_maps_are_those_of_each(count, touched, share):
    rng = np.random.default_rng(count)
    wear = rng.gamma(0.5, 1.0, (7, count)) * (rng.random((7, count)) < touched)
    found = subset_statistics(wear, share)
    for row, one in zip(found, wear, strict=True):
        expected = element_rates(one.reshape(1, -1), 1.0, 1.0, share)
        np.testing.assert_allclose(row, [expected[name] for name in OVER_ELEMENTS], rtol=1e-12)


def slow_stderr(parts, area, window, share=0.95):
    """The error from the written definition: all pairs of disjoint sets, each map by itself."""
    used = 2 * (len(parts) // 2)
    half = used // 2
    quarter = math.ceil(half / 2)
    seconds = window / len(parts)

    def rates(chosen):
        return element_rates(parts[list(chosen)].sum(axis=0), area, len(chosen) * seconds, share)

    def variance(size, name):
        sets = {one: rates(one)[name] for one in itertools.combinations(range(used), size)}
        return np.mean(
            [
                0.5 * (sets[a] - sets[b]) ** 2
                for a, b in itertools.combinations(sets, 2)
                if not set(a) & set(b)
            ]
        )

    found = {}
    for name in OVER_ELEMENTS:
        of_half = variance(half, name)
        exponent = np.log(of_half / variance(quarter, name)) / np.log(half / quarter)
        found[name] = np.sqrt(of_half * (len(parts) / half) ** np.clip(exponent, -2.0, 0.0))
    return found


@pytest.mark.parametrize("parts", [4, 5, 8, 10])
def test_the_error_is_that_of_the_written_definition(parts):
    rng = np.random.default_rng(parts)
    wear = gamma_parts(rng, parts, (6, 5), mean=0.3)
    found = element_stderr(wear, 2e-4, 3.0)
    assert found == pytest.approx(slow_stderr(wear, 2e-4, 3.0), rel=1e-9)


@pytest.mark.parametrize("parts", [8, 10, 12])
def test_the_error_of_a_mean_is_the_scatter_of_the_parts_over_the_root_of_their_number(parts):
    # All elements are worn in every part, so `worn` is the mean of the plate. With one element all
    # statistics are.
    rng = np.random.default_rng(0)
    area, window = 1e-4, 3.0
    for shape in ((7, 3), (1, 1)):
        wear = 1.0 + gamma_parts(rng, parts, shape)
        rates = wear.mean(axis=(1, 2)) / (area * window / parts)
        expected = rates.std(ddof=1) / np.sqrt(parts)
        found = element_stderr(wear, area, window)
        names = ["worn"] if shape == (7, 3) else OVER_ELEMENTS
        for name in names:
            assert found[name] == pytest.approx(expected, rel=1e-9)


def test_correlated_parts_enlarge_the_error_as_correlated_batches_do():
    # One element, whose work rises in five parts and falls in five.
    work = np.array([1.0, 2.0, 3.0, 4.0, 5.0, 5.0, 4.0, 3.0, 2.0, 1.0])
    deviation = work - work.mean()
    lag1 = (deviation[1:] @ deviation[:-1]) / (deviation @ deviation)
    plain = work.std(ddof=1) / np.sqrt(10.0)
    found = element_stderr(work.reshape(10, 1, 1), 1.0, 10.0)
    assert lag1 > 1.645 / np.sqrt(10.0)
    assert found["max"] == pytest.approx(plain * np.sqrt((1.0 + lag1) / (1.0 - lag1)))


def test_few_parts_tell_no_error_and_unworn_plates_have_none():
    assert all(math.isnan(value) for value in element_stderr(np.ones((3, 2, 2)), 1.0, 1.0).values())
    assert element_stderr(np.zeros((10, 2, 2)), 1.0, 1.0) == dict.fromkeys(OVER_ELEMENTS, 0.0)
    # Ten equal parts have no scatter.
    same = np.broadcast_to(np.arange(4.0).reshape(2, 2), (10, 2, 2))
    assert element_stderr(same, 1.0, 1.0) == pytest.approx(
        dict.fromkeys(OVER_ELEMENTS, 0.0), abs=1e-15
    )


def test_the_error_scales_with_the_wear_and_against_area_and_time():
    wear = gamma_parts(np.random.default_rng(2), 10, (5, 4), mean=0.5)
    once = element_stderr(wear, 1.0, 1.0)
    assert element_stderr(4.0 * wear, 0.5, 2.0) == pytest.approx(
        {name: 4.0 * value for name, value in once.items()}, rel=1e-12
    )


def stated_over_true(draw, repeats, area=1.0, window=1.0):
    """Root mean square of the stated errors over the scatter of the repeats, by statistic."""
    stated, rates = [], []
    for _ in range(repeats):
        parts = draw()
        stated.append(list(element_stderr(parts, area, window).values()))
        rates.append(list(element_rates(parts.sum(axis=0), area, window).values()))
    ratio = np.sqrt(np.mean(np.square(stated), axis=0)) / np.std(rates, axis=0, ddof=1)
    return dict(zip(OVER_ELEMENTS, ratio, strict=True))


def test_errors_of_independent_elements_hold_for_extremes_too():
    # 100 elements of one mean and variance: the worst one is the largest of 100 normal variables,
    # whose scatter is 0.43 of that of an element. Both scatters are known to 7 % from 200 repeats.
    rng = np.random.default_rng(3)
    ratios = stated_over_true(lambda: gamma_parts(rng, 10, (10, 10), mean=20.0), 200)
    for name in ("worn", "p99", "max"):
        assert ratios[name] == pytest.approx(1.0, abs=0.25), name


def test_errors_hold_where_few_impacts_wear_some_of_the_elements():
    # Impacts of random strength at random times, each on one element: 40 in the window on average,
    # on 144 elements.
    rng = np.random.default_rng(4)

    def draw():
        wear = np.zeros((10, 12, 12))
        impacts = rng.poisson(40)
        part, x, z = rng.integers(10, size=impacts), *rng.integers(12, size=(2, impacts))
        np.add.at(wear, (part, x, z), rng.gamma(2.0, 1.0, impacts))
        return wear

    ratios = stated_over_true(draw, 200)
    for name in ("worn", "footprint", "max"):
        assert 0.75 < ratios[name] < 1.4, name


# Simulations

CROWDED = {
    "mass_rate": 42.0, "patch_length": 0.3, "patch_width": 0.3, "angle_acts": "arc",
    "fall_height": 0.385, "arc_radius": 0.235, "time_step_fraction": 0.2, "window": 2.5,
    "max_time": 12.0, "target_stderr": 0.5,
}  # fmt: skip


@pytest.fixture(scope="module")
def replicates():
    """Wear rates of 60 replicates of a crowded jet of large particles, elements of 30 mm."""
    row = {q.name: float(np.mean(q.paper_range)) for q in SAMPLED} | {
        "particle_radius": 0.03, "plate_angle": 40.0, "case_id": 0, "block": 0, "rejected": "",
    }  # fmt: skip
    found = []
    for seed in range(60):
        case = {**row, "seed": seed}
        tables = run_case(case, CROWDED)
        found.append(
            wear_rates(
                **{name: tables[name] for name in TABLES},
                cases=pd.DataFrame([case]),
                setup=Setup.from_dict(CROWDED),
                element_size=0.03,
            )
        )
    return pd.concat(found, ignore_index=True)


@pytest.mark.parametrize("column", WEAR_COLUMNS)
def test_the_stated_error_is_the_scatter_over_the_seeds(replicates, column):
    stated = np.sqrt(np.mean(replicates[stderr_column(column)] ** 2))
    true = replicates[column].std(ddof=1)
    # The scatter of 60 seeds is itself known to 9 %.
    assert 0.7 < stated / true < 1.5


def test_every_wear_rate_has_an_error_of_its_own(replicates):
    assert (replicates[list(STDERR_COLUMNS)] > 0.0).all(axis=None)
    errors = replicates[list(STDERR_COLUMNS)].mean()
    assert errors.nunique() == len(WEAR_COLUMNS)
    # The worst element is known less well than the mean of the plate.
    for measure in ("total", "sliding", "friction"):
        worst, mean = (stderr_column(wear_column(measure, name)) for name in ("max", "mean"))
        assert errors[worst] > 3.0 * errors[mean]

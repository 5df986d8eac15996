"""Wear rates of series and maps with known rates."""

import numpy as np
import pandas as pd
import pytest

from abradem.dem.model import Setup
from abradem.figures.maps import depth_rate_maps
from abradem.figures.series import depth_series
from abradem.quantities import (
    SAMPLED,
    STATISTICS,
    STDERR_COLUMNS,
    WEAR_COLUMNS,
    WEAR_MEASURES,
    wear_column,
)
from abradem.report.summary import quality_counts
from abradem.wear import rates as wr

SETUP = Setup(plate_length=0.2, plate_width=0.1, facet_size=0.05, window=2.0)  # 4 x 2 facets


def straight_study(rates=(2.0, 1.0, 0.5), w=1e-9, start=1.0, end=7.0, keys=(5,)):
    """Tables of cases whose wear begins at ``start`` and rises at constant rates (J/s)."""
    time = np.linspace(0.0, end, 351)
    series = pd.concat(
        pd.DataFrame(
            {
                "case_id": key,
                "time": time,
                **{
                    f"worn_{measure}": rate * np.maximum(time - start, 0.0)
                    for measure, rate in zip(WEAR_MEASURES, rates, strict=True)
                },
                "delivered_mass": 4.0 * time,
            }
        )
        for key in keys
    )
    facet_x, facet_z = (index.ravel() for index in np.indices(SETUP.facets))
    share = np.array([0.0, 0.0, 0.5, 0.2, 0.1, 0.1, 0.07, 0.03])
    maps = pd.concat(
        pd.DataFrame(
            {
                "case_id": key,
                "facet_x": facet_x,
                "facet_z": facet_z,
                **{
                    f"wear_{measure}": 2.0 * rate * share
                    for measure, rate in zip(WEAR_MEASURES, rates, strict=True)
                },
            }
        )
        for key in keys
    )
    runs = pd.DataFrame({"case_id": list(keys), "status": "ok"}).assign(
        steady_from=start, window_start=start, window_end=start + 2.0, delivered_rate=4.0,
        requested_rate=4.0, max_overlap=0.01, simulated_time=end,
    )  # fmt: skip
    cases = pd.DataFrame({"case_id": list(keys), "archard_constant": w})
    for row in SAMPLED:
        cases[row.name] = cases.get(row.name, np.mean(row.paper_range))
    return series, maps, runs, cases


def parts_of(maps, shares):
    """Table of parts that hold these shares of the wear of the window, without unworn facets."""
    parts = pd.concat(
        maps.assign(
            window_part=part,
            **{f"part_wear_{name}": share * maps[f"wear_{name}"] for name in WEAR_MEASURES},
        )
        for part, share in enumerate(shares)
    )
    return parts[parts["part_wear_total"] > 0.0].drop(columns=[f"wear_{n}" for n in WEAR_MEASURES])


def test_slope_of_a_straight_line_is_exact():
    time = np.linspace(0.0, 6.0, 301)
    fit = wr.steady_rate(time, 3.5 * time + 1.0, 0.7)
    assert fit.rate == pytest.approx(3.5, rel=1e-13)
    assert fit.stderr == pytest.approx(0.0, abs=1e-12)
    assert fit.r2 == pytest.approx(1.0, abs=1e-12)
    assert fit.batches == 40


def test_the_standard_error_of_white_increments_is_the_known_one():
    # 12 cosines: an error scatters by 1 / sqrt(2 * 12) = 20 %, the mean square of 300 by 2 %.
    rng = np.random.default_rng(3)
    time = np.arange(0.0, 8.0001, 0.02)
    sigma, samples = 0.3, len(time) - 1
    known = sigma * np.sqrt(samples) / time[-1]
    fits = []
    for _ in range(300):
        worn = np.concatenate([[0.0], np.cumsum(1.0 + sigma * rng.standard_normal(samples))])
        fits.append(wr.steady_rate(time, worn, 0.0))
    rates = np.array([fit.rate for fit in fits])
    assert rates.std() == pytest.approx(known, rel=4 / np.sqrt(2 * 300))
    # The correction for correlated batches acts by chance in about 5 % of the repeats.
    plain = [fit.stderr for fit in fits if fit.lag1 < 0.3]
    assert np.sqrt(np.mean(np.square(plain))) == pytest.approx(known, rel=0.06)
    covered = np.abs(rates - 50.0) <= 2.18 * np.array([fit.stderr for fit in fits])
    assert covered.mean() > 0.91


def test_a_series_without_a_steady_part_has_no_rate():
    time = np.linspace(0.0, 1.0, 51)
    for start in (np.nan, 1.0, 2.0, 0.9):
        assert np.isnan(wr.steady_rate(time, time, start).rate)
    assert np.isnan(wr.steady_rate(np.array([0.0]), np.array([0.0]), 0.0).rate)


def test_straightness_is_one_for_a_line_and_known_for_a_parabola():
    t = np.linspace(0.0, 1.0, 20001)
    assert wr.straightness(t, -2.0 * t) == pytest.approx(1.0, abs=1e-12)
    # t and t^2 on [0, 1]: cov = 1/12, variances 1/12 and 4/45, hence R2 = 15/16.
    assert wr.straightness(t, t**2) == pytest.approx(15 / 16, abs=1e-4)
    assert np.isnan(wr.straightness(t, np.zeros_like(t)))


def test_the_footprint_is_the_fewest_facets_that_hold_the_share():
    wear = np.array([[1.0, 50.0], [4.0, 45.0]])
    assert wr.footprint(wear, 0.95).tolist() == [[False, True], [False, True]]
    assert wr.footprint(wear, 0.96).sum() == 3
    assert wr.footprint(wear, 0.5).sum() == 1
    assert wr.footprint(wear, 1.0).all()
    assert not wr.footprint(np.zeros((2, 2))).any()


def test_uniform_wear_has_one_depth_rate_in_every_statistic():
    wear = np.full((20, 5), 6.0)
    rates = wr.element_rates(wear, element_area=1e-4, window=3.0)
    assert rates == pytest.approx(dict.fromkeys(STATISTICS[1:], 6.0 / 3e-4))
    assert wr.footprint(wear).sum() == 95


def test_facet_statistics_of_a_known_map():
    wear = np.arange(1.0, 102.0).reshape(1, 101)  # percentiles of 1..101 are exact
    rates = wr.element_rates(wear, element_area=0.5, window=2.0)
    assert rates["max"] == 101.0
    assert rates["p99"] == pytest.approx(100.0)
    # 23..101 hold 4898 of 5151 J = 95.09 %, 24..101 only 94.6 %.
    assert rates["footprint"] == pytest.approx(np.mean(np.arange(23, 102)))
    assert rates["worn"] == pytest.approx(np.mean(np.arange(1, 102)))
    assert wr.element_rates(np.where(wear > 50.0, wear, 0.0), 0.5, 2.0)["worn"] == pytest.approx(
        np.mean(np.arange(51, 102))
    )
    nothing = wr.element_rates(np.zeros((2, 2)), 1.0, 1.0)
    assert nothing == dict.fromkeys(STATISTICS[1:], 0.0)


def test_elements_are_squares_of_whole_facets():
    setup = Setup(plate_length=0.3, plate_width=0.2, facet_size=0.01)
    assert wr.element_counts(setup, None) == (30, 20)
    assert wr.element_counts(setup, 0.05) == (6, 4)
    assert wr.element_counts(setup, 0.1) == (3, 2)
    for size in (0.03, 0.04, 0.004, 0.015, 0.2, 1.0):
        with pytest.raises(ValueError, match="into elements of whole facets"):
            wr.element_counts(setup, size)
    # A slow twin: each element sums its own facets.
    wear = np.random.default_rng(0).random((30, 20))
    found = wr.element_wear(wear, (6, 4))
    for i in range(6):
        for k in range(4):
            of_element = wear[5 * i : 5 * i + 5, 5 * k : 5 * k + 5]
            assert found[i, k] == pytest.approx(of_element.sum())


def test_coarser_elements_have_a_smaller_worst_one_and_the_same_mean():
    wear = np.random.default_rng(1).random((12, 12)) ** 8
    worst = []
    for count in (12, 6, 4, 3, 2, 1):
        of_elements = wr.element_wear(wear, (count, count))
        rates = wr.element_rates(of_elements, 1.0 / count**2, 1.0)
        worst.append(rates["max"])
        assert of_elements.sum() == pytest.approx(wear.sum())
    assert worst == sorted(worst, reverse=True)
    assert worst[-1] == pytest.approx(wear.sum())


def test_depth_rates_of_a_straight_study_are_w_times_power_per_area():
    rates = wr.wear_rates(*straight_study(), SETUP).iloc[0]
    area, facet = 0.02, 0.02 / 8
    for measure, power in zip(WEAR_MEASURES, (2.0, 1.0, 0.5), strict=True):
        watt = 1e-9 * power * 1e3  # mm3/s per m2 in the end
        assert rates[f"wear_{measure}_mean"] == pytest.approx(watt / area, rel=1e-12)
        assert rates[f"wear_{measure}_max"] == pytest.approx(0.5 * watt / facet, rel=1e-12)
        # .5 + .2 + .1 + .1 + .07 = .97 on five facets.
        assert rates[f"wear_{measure}_footprint"] == pytest.approx(0.97 / 5 * watt / facet)
        shares = [0.0, 0.0, 0.5, 0.2, 0.1, 0.1, 0.07, 0.03]
        assert rates[f"wear_{measure}_p99"] == pytest.approx(
            np.percentile(shares, 99) * watt / facet
        )
    assert rates["worn_volume_rate"] == pytest.approx(2e-9, rel=1e-12)
    assert rates["wear_per_kg"] == pytest.approx(0.5e-9, rel=1e-12)
    assert rates["wear_r2"] == pytest.approx(1.0)
    assert rates["quality"] == "ok"


def test_the_map_of_a_steady_case_has_the_mean_of_the_slope():
    series, maps, runs, cases = straight_study()
    facets, _ = depth_rate_maps(maps, runs, cases, SETUP, [5], "total")
    rates = wr.wear_rates(series, maps, runs, cases, SETUP)
    assert facets["depth_rate"].mean() == pytest.approx(rates["wear_total_mean"][0], rel=1e-12)
    assert facets["x"].min() == pytest.approx(-75.0) and facets["z"].max() == pytest.approx(25.0)


def test_wear_is_exactly_proportional_to_w():
    rng = np.random.default_rng(0)
    series, maps, runs, cases = straight_study()
    for measure in WEAR_MEASURES:
        series[f"worn_{measure}"] += np.cumsum(rng.random(len(series)) * 0.01)
    parts = parts_of(maps, rng.dirichlet(np.ones(10)))
    runs["window_parts"] = 10
    once = wr.wear_rates(series, maps, runs, cases, SETUP, parts=parts)
    heavy = cases.assign(archard_constant=4e-9)
    twice = wr.wear_rates(series, maps, runs, heavy, SETUP, parts=parts)
    scaled = [*WEAR_COLUMNS, *STDERR_COLUMNS, "worn_volume_rate", "wear_per_kg"]
    assert (once[list(STDERR_COLUMNS)] > 0).all(axis=None)
    pd.testing.assert_frame_equal(twice[scaled], 4.0 * once[scaled], check_exact=True)
    same = [name for name in once if name not in scaled]
    pd.testing.assert_frame_equal(twice[same], once[same], check_exact=True)


def test_cases_are_told_apart_whatever_the_order_of_rows():
    series, maps, runs, cases = straight_study(keys=(9, 2, 4))
    cases["archard_constant"] = [9e-9, 2e-9, 4e-9]
    mixed = [
        series.sort_values("time", kind="stable"), maps.iloc[::-1], runs.iloc[::-1], cases,
    ]  # fmt: skip
    rates = wr.wear_rates(*mixed, SETUP)
    assert list(rates["case_id"]) == [2, 4, 9]
    np.testing.assert_allclose(rates["worn_volume_rate"], [4e-9, 8e-9, 18e-9], rtol=1e-12)


def test_facets_left_out_of_a_map_are_unworn():
    series, maps, runs, cases = straight_study()
    full = wr.wear_rates(series, maps, runs, cases, SETUP)
    sparse = wr.wear_rates(series, maps[maps["wear_total"] > 0], runs, cases, SETUP)
    pd.testing.assert_frame_equal(full, sparse)


def test_errors_of_parts_that_differ_in_time_alone_are_those_of_their_scatter():
    # Every part has the same map times a share, so every statistic is a mean over the parts.
    series, maps, runs, cases = straight_study(keys=(3, 5))
    shares = np.random.default_rng(1).permutation(np.arange(6.0, 16.0)) / 105.0
    runs["window_parts"] = 10
    rates = wr.wear_rates(series, maps, runs, cases, SETUP, parts=parts_of(maps, shares))
    scatter = 10.0 * shares.std(ddof=1) / np.sqrt(10.0)
    for measure in WEAR_MEASURES:
        for statistic in STATISTICS[1:]:
            name = wear_column(measure, statistic)
            np.testing.assert_allclose(rates[f"{name}_stderr"], scatter * rates[name], rtol=1e-9)


def test_parts_without_wear_count_and_without_the_table_errors_of_elements_are_unknown():
    series, maps, runs, cases = straight_study()
    runs["window_parts"] = 10
    shares = np.array([0.5, 0.0, 0.1, 0.0, 0.0, 0.4, 0.0, 0.0, 0.0, 0.0])
    rates = wr.wear_rates(series, maps, runs, cases, SETUP, parts=parts_of(maps, shares)).iloc[0]
    expected = 10.0 * shares.std(ddof=1) / np.sqrt(10.0)
    assert rates["wear_total_max_stderr"] == pytest.approx(expected * rates["wear_total_max"])
    without = wr.wear_rates(series, maps, runs, cases, SETUP).iloc[0]
    known = [name for name in STDERR_COLUMNS if name.endswith("_mean_stderr")]
    assert without[known].notna().all()
    assert without.drop(known)[[name for name in STDERR_COLUMNS if name not in known]].isna().all()
    pd.testing.assert_series_equal(rates[list(WEAR_COLUMNS)], without[list(WEAR_COLUMNS)])


def test_cases_that_ended_early_have_no_row():
    series, maps, runs, cases = straight_study(keys=(1, 2))
    runs.loc[0, "status"] = "overlap of 21 % of the radius"
    assert list(wr.wear_rates(series, maps, runs, cases, SETUP)["case_id"]) == [2]
    runs["status"] = "rejected: too large"
    empty = wr.wear_rates(series.iloc[:0], maps.iloc[:0], runs, cases, SETUP)
    assert list(empty.columns) == wr.RATE_COLUMNS and empty.empty


def test_a_case_without_a_steady_state_has_no_rates_and_says_so():
    series, maps, runs, cases = straight_study()
    runs[["steady_from", "window_start", "window_end"]] = np.nan
    maps[["wear_total", "wear_sliding", "wear_friction"]] = np.nan
    rates = wr.wear_rates(series, maps, runs, cases, SETUP).iloc[0]
    assert rates[list(WEAR_COLUMNS)].isna().all()
    assert "unsteady" in rates["quality"]


@pytest.mark.parametrize(
    ("change", "flags"),
    [
        ({}, "ok"),
        ({"delivered_rate": 3.79}, "shortfall"),
        ({"max_overlap": 0.051}, "overlap"),
        ({"delivered_rate": 1.0, "max_overlap": 0.1}, "shortfall+overlap"),
        ({"settled": False}, "unsteady"),
        ({"requested_rate": np.nan}, "ok"),
    ],
)
def test_quality_flags_name_what_is_wrong(change, flags):
    run = straight_study()[2].iloc[0].to_dict() | change
    assert wr.quality(run, 0.01, SETUP) == flags


def test_a_standard_error_above_the_one_aimed_at_is_flagged():
    run = straight_study()[2].iloc[0].to_dict()
    assert wr.quality(run, 0.021, SETUP) == "stderr"
    assert wr.quality(run, np.nan, SETUP) == "stderr"


def test_the_summary_counts_straight_series_and_flags():
    rates = pd.DataFrame(
        {
            "case_id": [0, 1, 2],
            "wear_r2": [0.99, 0.95, 0.5],
            "wear_total_mean": 1.0,
            "wear_total_mean_stderr": [0.01, 0.02, 0.06],
            "quality": ["ok", "stderr", "overlap+stderr"],
        }
    )
    assert quality_counts(rates, "wear_total_mean", 0.95) == {
        "cases": 3,
        "good_r2": 0.95,
        "cases_with_good_r2": 2,
        "cases_without_flag": 1,
        "flags": {"overlap": 1, "stderr": 2},
        "median_relative_stderr": pytest.approx(0.02),
    }


def test_fewer_than_twenty_batches_are_refused():
    with pytest.raises(ValueError, match="at least 20"):
        wr.wear_rates(*straight_study(), SETUP, min_batches=10)


def test_the_fitted_line_runs_through_the_ends_of_the_steady_part():
    series, _, runs, cases = straight_study()
    curves, fits = depth_series(series, runs, cases, SETUP, [5, 77], "total")
    assert list(fits["case_id"]) == [5]
    row = fits.iloc[0]
    assert row["depth_from"] == pytest.approx(0.0, abs=1e-18)
    assert row["depth_to"] == pytest.approx(curves["wear_depth"].iloc[-1], rel=1e-12)
    assert row["rate"] == pytest.approx(1e-9 * 2.0 / 0.02 * 1e3, rel=1e-12)


def test_a_map_of_another_plate_is_refused():
    series, maps, runs, cases = straight_study()
    with pytest.raises(ValueError, match="facet"):
        wr.wear_rates(series, maps, runs, cases, Setup(window=2.0, facet_size=0.3))

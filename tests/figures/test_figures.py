"""Figures: finite data, units in labels, nothing clipped or missing, reproducible bytes."""

import numpy as np
import pandas as pd
import pytest
from figure_checks import SETUP, assert_fit_to_print, study, texts

from abradem.dataset.features import derive
from abradem.figures import linear as linear_figures
from abradem.figures import maps as map_figures
from abradem.figures import quality as quality_figures
from abradem.figures import series as series_figures
from abradem.figures import style
from abradem.figures.maps import depth_rate_maps
from abradem.figures.quality import quality_table
from abradem.figures.series import depth_series
from abradem.learning.baselines.linear import fit_linear
from abradem.quantities import QUANTITIES, WEAR_COLUMNS
from abradem.wear.rates import wear_rates
from abradem.words.wear import WearTarget

MEAN = WearTarget("wear_total_mean")


def linear_result(n):
    series, maps, runs, cases = study(n)
    rates = wear_rates(series, maps, runs, cases, SETUP)
    return fit_linear(derive(cases).assign(case_id=cases["case_id"], **rates[list(WEAR_COLUMNS)]))


@pytest.fixture(scope="module")
def dozen():
    return study(12)


@pytest.fixture(scope="module", params=[12, 60])
def fitted(request):
    return linear_result(request.param)


def test_series_panels_show_finite_curves_with_units_and_slopes(dozen):
    series, _, runs, cases = dozen
    figure = series_figures.series_figure(
        *depth_series(series, runs, cases, SETUP, range(6), "total"), MEAN
    )
    assert len(figure.axes) == 6
    for panel in figure.axes:
        curve, slope = panel.lines
        assert len(curve.get_xdata()) == 201
        assert np.isfinite(curve.get_ydata()).all() and np.isfinite(slope.get_ydata()).all()
        assert "mm" in panel.get_ylabel() and "(s)" in panel.get_xlabel()
        # The fitted slope begins and ends on the curve.
        assert slope.get_ydata()[1] == pytest.approx(curve.get_ydata()[-1])
    assert "mm/s" in texts(figure) and "case 5" in texts(figure)
    assert_fit_to_print(figure)


def test_series_of_cases_without_steady_state_or_rejected_say_so(dozen):
    series, maps, runs, cases = (table.copy() for table in dozen)
    runs.loc[1, ["steady_from", "window_start", "window_end"]] = np.nan
    runs.loc[2, ["steady_from", "window_start", "window_end"]] = np.nan
    runs.loc[2, "status"] = "rejected: three particles side by side do not fit on the patch"
    series, maps = series[series["case_id"] != 2], maps[maps["case_id"] != 2]
    shown = [0, 1, 2]
    for figure in (
        series_figures.series_figure(
            *depth_series(series, runs, cases, SETUP, shown, "total"), MEAN
        ),
        map_figures.wear_maps_figure(
            *depth_rate_maps(maps, runs, cases, SETUP, shown, "total"), MEAN
        ),
    ):
        words = texts(figure).replace("\n", " ")
        assert "no steady state" in words and "side by side do not fit" in words
        assert_fit_to_print(figure)


def test_figures_of_cases_that_do_not_exist_say_so(dozen):
    series, maps, runs, cases = dozen
    for figure in (
        series_figures.series_figure(
            *depth_series(series, runs, cases, SETUP, [99], "total"), MEAN
        ),
        map_figures.wear_maps_figure(
            *depth_rate_maps(maps, runs, cases, SETUP, [99], "total"), MEAN
        ),
    ):
        assert "none of the cases" in texts(figure).replace("\n", " ")


def test_wear_maps_show_every_facet_on_the_plate_with_a_bar_in_mm_per_s(dozen):
    _, maps, runs, cases = dozen
    facets, panels = depth_rate_maps(maps, runs, cases, SETUP, [0, 3, 7, 8], "total")
    figure = map_figures.wear_maps_figure(facets, panels, MEAN)
    drawn = [panel for panel in figure.axes if panel.get_xlabel() == "Up the slope (mm)"]
    assert len(drawn) == 4
    for panel, key in zip(drawn, (0, 3, 7, 8), strict=True):
        (mesh,) = panel.collections
        values = mesh.get_array()
        assert values.size == 36 and np.isfinite(values).all()
        largest = facets.loc[facets["case_id"] == key, "depth_rate"].max()
        ratio = largest / values.max()
        assert np.log10(ratio) == pytest.approx(np.round(np.log10(ratio)))
        assert panel.get_xlim() == pytest.approx((-150.0, 150.0))
        assert mesh.get_clim()[0] == 0.0
    assert "Depth rate" in texts(figure) and "mm/s" in texts(figure)
    assert_fit_to_print(figure)


def test_a_map_shows_x_to_the_right_and_z_upwards():
    _, maps, runs, cases = study(1)
    maps[["wear_total"]] = 0.0
    maps.loc[(maps["facet_x"] == 5) & (maps["facet_z"] == 1), "wear_total"] = 1.0
    figure = map_figures.wear_maps_figure(
        *depth_rate_maps(maps, runs, cases, SETUP, [0], "total"), MEAN
    )
    values = np.asarray(figure.axes[0].collections[0].get_array()).reshape(6, 6)
    assert np.unravel_index(values.argmax(), values.shape) == (1, 5)
    # Facets without wear have no colour of the scale, and the legend says so.
    hidden = np.ma.getmaskarray(figure.axes[0].collections[0].get_array())
    assert hidden.sum() == 35 and "no wear" in texts(figure)


@pytest.mark.parametrize(
    "name", ["wear_sliding_mean", "wear_friction_p99", "wear_total_max", "wear_friction_footprint"]
)
def test_series_maps_and_quality_follow_the_target(dozen, name):
    series, maps, runs, cases = dozen
    target = {"name": name, "element_size": 0.1}
    said, setup = WearTarget(**target), {"facet_size": 0.05, "window": 2.0}
    figures = {
        "series": series_figures.draw([series], [runs], [cases], setup, [0, 1], 20, target),
        "maps": map_figures.draw([maps], [runs], [cases], setup, [0, 1], target),
        "quality": quality_figures.draw(wear_rates(*dozen, SETUP), target, 0.02, 0.95),
    }
    words = {key: texts(figure).replace("\n", " ") for key, figure in figures.items()}
    assert f"wear measure: {said.measure};" in words["series"]
    assert f"Wear measure: {said.measure};" in words["maps"]
    assert said.place in words["quality"]
    share = {"total": 1.0, "sliding": 0.4, "friction": 0.5}[said.measure]
    curve = figures["series"].axes[0].lines[0].get_ydata()
    depth = 1e3 * cases["archard_constant"][0] / 0.09 * share * series["worn_total"].iloc[:201]
    assert curve / curve[-1] == pytest.approx((depth / depth.iloc[-1]).to_numpy())
    scale = np.log10(depth.iloc[-1] / curve[-1])
    assert scale == pytest.approx(round(scale), abs=1e-9)
    # The plate of 300 mm has three elements of 100 mm along each side, so two lines between them.
    inner = [line.get_xdata()[0] for line in figures["maps"].axes[0].lines[:2]]
    elements = said.statistic != "mean"
    assert inner == pytest.approx([-50.0, 50.0] if elements else [])
    assert ("the models predict another statistic" in words["series"]) == elements
    assert (f"elements of the target, {said.place}" in words["maps"]) == elements
    # The stop rule aims at the error of the mean of total alone.
    assert "at most 2 %" not in words["quality"]
    for figure in figures.values():
        assert_fit_to_print(figure)


def test_elements_of_one_facet_have_no_lines(dozen):
    _, maps, runs, cases = dozen
    for size in (0.05, None):
        said = WearTarget("wear_total_max", size)
        found = depth_rate_maps(maps, runs, cases, SETUP, [0], "total")
        assert not map_figures.wear_maps_figure(*found, said).axes[0].lines


def test_the_quality_of_a_target_is_that_of_its_own_error():
    rates = pd.DataFrame(
        {
            "case_id": range(4), "quality": "ok", "wear_r2": [0.9, 0.99, 0.999, 0.99],
            "wear_total_mean": 1.0, "wear_total_mean_stderr": 0.5,
            "wear_friction_p99": [1.0, 2.0, 4.0, 0.0],
            "wear_friction_p99_stderr": [0.1, 0.1, 0.1, 0.1],
        }
    )  # fmt: skip
    table = quality_table(rates, "wear_friction_p99")
    np.testing.assert_allclose(table["relative_stderr"], [0.1, 0.05, 0.025, np.nan])
    figure = quality_figures.quality_figure(table, WearTarget("wear_friction_p99", 0.03), 0.02)
    left, right = figure.axes
    assert sum(bar.get_height() for bar in left.patches) == 3
    assert sum(bar.get_height() for bar in right.patches) == 4
    words = texts(figure).replace("\n", " ")
    assert "3 of 4 cases, median 5 %" in words and "99th percentile of 30 mm elements" in words
    assert_fit_to_print(figure)
    unknown = quality_table(rates.drop(columns="wear_friction_p99_stderr"), "wear_friction_p99")
    figure = quality_figures.quality_figure(unknown, WearTarget("wear_friction_p99"), 0.02)
    assert "standard error of the target is not known" in texts(figure).replace("\n", " ")
    assert_fit_to_print(figure)


def test_coefficient_bars_carry_symbols_and_intervals(fitted):
    figure = linear_figures.coefficients_figure(fitted.coefficients, fitted.summary)
    heights = [bar.get_height() for panel in figure.axes for bar in panel.patches]
    # Twelve rows do not tell 20 coefficients apart.
    identified = fitted.coefficients["identified"]
    assert identified.all() or not identified.any()
    np.testing.assert_allclose(heights, fitted.coefficients["coefficient"].where(identified))
    assert ("not identified" in texts(figure)) == (not identified.any())
    labels = [label.get_text() for panel in figure.axes for label in panel.get_xticklabels()]
    assert [label.split("\n")[0] for label in labels] == [f"X{i}" for i in range(1, 21)]
    for panel in figure.axes:
        low, high = panel.get_ylim()
        assert not identified.any() or (low < min(heights) and max(heights) < high)
    words = texts(figure)
    rows = fitted.summary["splits"]["rows"]
    assert f"{rows} cases" in words
    assert ("no intervals" in words) == (rows == 12)
    assert ("intervals (HC3)" in words) == (rows == 60)
    assert_fit_to_print(figure)


def test_predicted_against_actual_shows_held_out_rows_score_and_protocol(fitted):
    figure = linear_figures.predicted_figure(fitted.predictions, fitted.summary)
    (panel,) = figure.axes
    points = panel.collections[0].get_offsets()
    leakage_free = fitted.predictions.query("protocol == 'leakage_free'")
    assert len(points) == len(leakage_free) and np.isfinite(points).all()
    words = texts(figure).replace("\n", " ")
    for part in (
        "held-out $R^2$",
        "1:1",
        "mm/s",
        "leakage-free protocol",
        "50 random splits",
        "test)",
    ):
        assert part in words
    (low, high), (bottom, top) = panel.get_xlim(), panel.get_ylim()
    assert ((points[:, 0] >= low) & (points[:, 0] <= high)).all()
    assert ((points[:, 1] >= bottom) & (points[:, 1] <= top)).all()
    assert_fit_to_print(figure)


def test_axes_are_logarithmic_if_wear_spans_decades_and_predictions_are_positive(fitted):
    actual = np.logspace(-6, -2, 50)
    table = fitted.predictions.iloc[:50].assign(actual=actual, predicted=1.3 * actual)
    panel = linear_figures.predicted_figure(table, fitted.summary).axes[0]
    assert (panel.get_xscale(), panel.get_yscale()) == ("log", "log")
    panel = linear_figures.predicted_figure(table.assign(predicted=-actual), fitted.summary).axes[0]
    assert panel.get_xscale() == "linear"


def test_a_score_that_cannot_be_computed_is_not_invented(fitted):
    none = dict.fromkeys(("mean", "median", "lower", "upper"))
    model = fitted.summary | {"scores": {"test": {"R2": none | {"unit": "1"}}}}
    assert "not determined" in texts(linear_figures.predicted_figure(fitted.predictions, model))


def test_quality_histograms_count_every_case(dozen):
    rates = wear_rates(*dozen, SETUP)
    quality = quality_table(rates, MEAN.name)
    figure = quality_figures.quality_figure(quality, MEAN, 0.02)
    for panel in figure.axes:
        assert sum(bar.get_height() for bar in panel.patches) == 12
    within = int((quality["relative_stderr"] <= 0.02).sum())
    assert f"{within} of 12 cases" in texts(figure) and "(%)" in texts(figure)
    assert_fit_to_print(figure)


@pytest.mark.parametrize("errors", [[0.001, 0.002], [0.02], [5.0, 0.01]])
def test_quality_bins_reach_all_values(errors):
    quality = pd.DataFrame(
        {"relative_stderr": errors, "wear_r2": np.linspace(1.0, 0.1, len(errors))}
    )
    figure = quality_figures.quality_figure(quality, MEAN, 0.02)
    for panel in figure.axes:
        assert sum(bar.get_height() for bar in panel.patches) == len(errors)


def test_saved_figures_are_the_same_bytes_and_of_journal_width(tmp_path, fitted):
    for folder in ("a", "b"):
        figure = linear_figures.coefficients_figure(fitted.coefficients, fitted.summary)
        style.save(figure, tmp_path / folder / "f")
    for name in ("f.pdf", "f.png"):
        assert (tmp_path / "a" / name).read_bytes() == (tmp_path / "b" / name).read_bytes()
    pdf = (tmp_path / "a" / "f.pdf").read_bytes()
    assert b"CreationDate" not in pdf
    assert b"/Type3" not in pdf and b"/FontFile2" in pdf
    width = int.from_bytes((tmp_path / "a" / "f.png").read_bytes()[16:20], "big")
    assert width == pytest.approx(180.0 / 25.4 * 300.0, abs=2)
    assert sorted(path.name for path in (tmp_path / "a").iterdir()) == ["f.pdf", "f.png"]


def test_an_unknown_format_is_refused_before_anything_is_written(tmp_path, fitted):
    figure = linear_figures.predicted_figure(fitted.predictions, fitted.summary)
    with pytest.raises(ValueError, match="format 'bmp' is unknown"):
        style.save(figure, tmp_path / "f", ["png", "bmp"])
    assert not list(tmp_path.iterdir())


def test_the_users_settings_do_not_change_a_figure(tmp_path, fitted):
    import matplotlib as mpl

    with mpl.rc_context({"font.size": 30.0, "axes.facecolor": "red", "savefig.dpi": 50}):
        figure = linear_figures.predicted_figure(fitted.predictions, fitted.summary)
        style.save(figure, tmp_path / "a", ["png"])
        assert mpl.rcParams["font.size"] == 30.0
    figure = linear_figures.predicted_figure(fitted.predictions, fitted.summary)
    style.save(figure, tmp_path / "b", ["png"])
    assert (tmp_path / "a.png").read_bytes() == (tmp_path / "b.png").read_bytes()


def test_labels_carry_the_units_of_the_table():
    assert style.axis_label("plate_angle") == r"Plate angle $\varphi$ (°)"
    assert style.axis_label("particle_density") == r"Particle density $\rho_p$ (kg/m³)"
    assert style.axis_label("restitution") == "Coefficient of restitution $e$"
    for row in QUANTITIES:
        assert (row.unit == "1") == (
            "(" not in style.axis_label(row.name).replace("(vertical)", "")
        )


@pytest.mark.parametrize(
    ("value", "error", "words"),
    [
        (2.534e-3, 3.4e-5, r"(2.534 ± 0.034)$\times$$10^{-3}$ mm/s"),
        (1.25, 0.1, "1.25 ± 0.10 mm/s"),
        (0.0, 0.0, "0.00 ± 0.00 mm/s"),
        (1.5e-6, np.nan, r"(1.50)$\times$$10^{-6}$ mm/s"),
        (np.nan, np.nan, "not determined"),
    ],
)
def test_values_are_printed_with_the_digits_their_error_leaves(value, error, words):
    assert style.with_error(value, error, "mm/s") == words


@pytest.mark.parametrize(
    ("largest", "power"), [(0.0, 0), (1.0, 0), (999.0, 0), (1000.0, 3), (0.5, -3), (2e-7, -9)]
)
def test_a_multiple_of_three_brings_numbers_to_between_one_and_a_thousand(largest, power):
    assert style.decade(largest) == power

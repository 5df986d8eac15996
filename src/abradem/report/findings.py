"""Findings of the physics-informed models as sentences for the report, generated from results."""

from __future__ import annotations

from collections.abc import Mapping

import pandas as pd

from abradem.learning.physical.models import BEST
from abradem.words.escaping import for_html
from abradem.words.labels import LABELS

NAMES = {
    "power_law": "power law",
    "gaussian_process": "Gaussian process",
    "boosting": "boosted trees",
    "networks": "ensemble of networks",
}


def findings(
    physical: Mapping,
    intervals: Mapping,
    surrogate: Mapping,
    sensitivity: Mapping,
    curve: pd.DataFrame,
    extrapolation: pd.DataFrame,
    indices: pd.DataFrame,
    falls: pd.DataFrame,
    noise: Mapping | None = None,
    speed: Mapping | None = None,
) -> list[tuple[str, str]]:
    """Findings of a study.

    Parameters
    ----------
    physical, intervals, surrogate, sensitivity : mapping
        Contents of the JSON files of these workflow steps.
    curve, extrapolation : pandas.DataFrame
        From `abradem.learning.physical.reach`.
    indices, falls : pandas.DataFrame
        From `abradem.learning.physical.sensitivity`.
    noise : mapping, optional
        From `abradem.learning.physical.noise_floor`; None without simulations.
    speed : mapping, optional
        From `abradem.learning.physical.speed_up`; None without simulations.

    Returns
    -------
    list of tuple of str
        Heading and text of each paragraph.
    """
    found = [
        ("Comparison", _comparison(physical, surrogate, noise)),
        ("Power law", f"{physical['equation']}. The residual scatter is "
                      f"{_percent(physical['scatter'])}."),
        ("Intervals", _intervals(intervals)),
        ("Learning curve", _curve(curve)),
    ]  # fmt: skip
    if len(extrapolation):
        found.append(("Extrapolation", _extrapolation(extrapolation)))
    found.append(("Sensitivity", _sensitivity(sensitivity, indices, falls)))
    if speed is not None:
        found.append(("Speed", _speed(speed)))
    return found


def to_html(title: str, paragraphs: list[tuple[str, str]]) -> str:
    """A self-contained HTML page with the findings."""
    body = "\n".join(
        f"<h2>{for_html(heading)}</h2>\n<p>{for_html(text)}</p>" for heading, text in paragraphs
    )
    return (
        '<!DOCTYPE html>\n<html lang="en">\n<head><meta charset="utf-8">'
        f"<title>{for_html(title)}</title>\n"
        "<style>body{font-family:sans-serif;max-width:46em;margin:2em auto;line-height:1.5}"
        "</style></head>\n"
        f"<body>\n<h1>{for_html(title)}</h1>\n{body}\n</body>\n</html>\n"
    )


def _comparison(physical: Mapping, surrogate: Mapping, noise: Mapping | None) -> str:
    scores = {**physical["scores"], "surrogate": surrogate["scores"]}
    names = {**NAMES, "surrogate": "surrogate distilled from the Gaussian process"}
    listed = "; ".join(
        f"{names[name]} {_number(scores[name]['test']['R2']['median'])} "
        f"({_number(scores[name]['test']['R2']['lower'])} to "
        f"{_number(scores[name]['test']['R2']['upper'])})"
        for name in names
    )
    text = (
        "R2 on held-out cases, median over the splits (surrogate: over the first splits) and "
        f"central share of the splits: {listed}."
    )
    if noise is not None and noise["r2_floor"] is not None:
        best = scores[BEST]["test"]["R2"]["median"]
        low, high = noise["r2_floor_band"]
        text += (
            f" The noise of the simulations limits any model to {noise['r2_floor']:.5f} "
            f"({low:.5f} to {high:.5f}, from {noise['replicates']} simulations of {noise['cases']} "
            f"cases with other seeds; {noise['r2_floor_of_stated_errors']:.5f} from the standard "
            f"errors of the simulations, whose variance is {1.0 / noise['ratio']:.2g} "
            "times that over the seeds). "
        )
        if best is not None:
            text += f"The {NAMES[BEST]} is {noise['r2_floor'] - best:.4f} below this limit."
    return text.strip()


def _intervals(intervals: Mapping) -> str:
    parts = ", ".join(
        f"{100.0 * one['level']:g} %: {100.0 * one['coverage']:.1f} % "
        f"(band {100.0 * one['band'][0]:.1f} to {100.0 * one['band'][1]:.1f}; "
        f"upper end {_percent(one['relative_width'])} above the prediction)"
        for one in intervals["coverage"]
    )
    verdicts = (
        "within" if intervals["in_band"] else "not all within",
        "all" if intervals["within_tolerance"] else "not all",
    )
    return (
        f"Share of {intervals['rows']} held-out cases inside the {intervals['method']} intervals, "
        f"by nominal level: {parts}. They are {verdicts[0]} the binomial bands, and {verdicts[1]} "
        f"within {100.0 * intervals['tolerance']:g} points of the nominal level."
    )


def _curve(curve: pd.DataFrame) -> str:
    parts = []
    for name, rows in curve.groupby("model", sort=False):
        steps = ", ".join(f"{row.r2:.4f} from {row.trained}" for row in rows.itertuples())
        parts.append(f"{NAMES[name]} {steps}")
    return f"R2 by number of training cases: {'; '.join(parts)}."


def _extrapolation(extrapolation: pd.DataFrame) -> str:
    parts = []
    for words, rows in extrapolation.groupby("words", sort=False):
        best = rows[rows["model"] == BEST].iloc[0]
        others = ", ".join(
            f"{NAMES[row.model]} {row.r2:.3f}" for row in rows[rows["model"] != BEST].itertuples()
        )
        parts.append(
            f"{words} ({best['tested']} cases): {NAMES[BEST]} {best['r2']:.3f} (trained on such "
            f"cases as well: {best['within_r2']:.3f}; {100.0 * best['coverage']:.0f} % inside its "
            f"95 % intervals), {others}"
        )
    return f"R2 on cases beyond the training ranges. {'. '.join(parts)}."


def _speed(speed: Mapping) -> str:
    return (
        f"For the same cases in one job on one core, a simulation takes "
        f"{speed['simulated_seconds']['mean']:.3g} s "
        f"(mean of {len(speed['cases'])} cases with particles of "
        f"{1e3 * min(speed['radii']):.0f} to {1e3 * max(speed['radii']):.0f} mm; "
        f"median {speed['simulated_seconds']['median']:.2g} s) and a prediction "
        f"{1e3 * speed['predicted_seconds']:.2g} ms. A single prediction is "
        f"{_round(speed['speed_up'])} times faster; with {speed['batch']} cases in one call "
        f"({speed['predictions_per_second']:.2g} predictions per second) it is "
        f"{_round(speed['speed_up_of_a_batch'])} times faster."
    )


def _number(value) -> str:
    return "n/a" if value is None else f"{value:.4f}"


def _percent(value: float) -> str:
    return f"{100.0 * value:.0f} %"


def _round(value: float) -> str:
    """A number with two digits, in thousands or millions."""
    for size, word in ((1e6, " million"), (1e3, " thousand")):
        if value >= size:
            return f"{float(f'{value / size:.2g}'):g}{word}"
    return f"{value:.2g}"


def _sensitivity(verdict: Mapping, indices: pd.DataFrame, falls: pd.DataFrame) -> str:
    wear = indices[indices["explained"] == "wear"].sort_values("total", ascending=False)
    total = wear.set_index("feature")["total"]
    by_loss = falls.sort_values("fall", ascending=False)
    count = len(verdict["dominant"])
    listed = ", ".join(
        f"{LABELS[row.feature].long_name} ({row.total:.2f}; first order {row.first:.2f})"
        for row in wear[:count].itertuples(index=False)
    )
    text = [
        "Four quantities explain most of the variance of the wear over the ranges of this data "
        f"set, by total Sobol index: {listed}."
    ]
    if verdict["agrees"]:
        text.append("They are the four named in the paper.")
    else:
        missed = [name for name in verdict["paper"] if name not in verdict["dominant"]]
        new = [name for name in verdict["dominant"] if name not in verdict["paper"]]
        shares = ", ".join(f"{total[name]:.2f}" for name in missed)
        text.append(
            f"The paper names {len(verdict['shared'])} of them; instead of {_listed(new)} it names "
            f"{_listed(missed)} (total index here: {shares})."
        )
    losses = [
        f"{LABELS[row.feature].long_name} ({row.fall:.2f})"
        for row in by_loss[1:4].itertuples(index=False)
    ]
    first = by_loss.iloc[0]
    text.append(
        f"When shuffled among held-out cases, {LABELS[first['feature']].long_name} causes the "
        f"largest fall of R2 ({first['fall']:.2f}), followed by {', '.join(losses)}."
    )
    if verdict["hardly_any_effect"]:
        text.append(
            "Hardly any effect (total index of ln wear below 0.01): "
            f"{_listed(verdict['hardly_any_effect'])}."
        )
    return " ".join(text)


def _listed(names) -> str:
    return ", ".join(LABELS[name].long_name for name in names)

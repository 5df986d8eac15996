"""Findings of the physics-informed models as sentences for the report, generated from results."""

from __future__ import annotations

from collections.abc import Collection, Mapping

import pandas as pd

from abradem.dataset.variation import HELD_FIXED, NOT_IDENTIFIED, VARIED
from abradem.learning.exponents import AGREES, COMBINED_ERRORS, LEAST_SPEED, UNKNOWN
from abradem.learning.number_text import (
    is_number,
    number_or_words,
    number_with_error,
    percentage,
    score_number,
    score_range,
)
from abradem.learning.physical.models import BEST
from abradem.learning.physical.reach import TESTS
from abradem.learning.protocols import LEAKAGE_FREE
from abradem.words.escaping import for_html
from abradem.words.labels import LABELS, POWER_LABELS
from abradem.words.wear import WearTarget

NAMES = {
    "power_law": "power law",
    "gaussian_process": "Gaussian process",
    "boosting": "boosted trees",
    "networks": "ensemble of networks",
    "stacked": "process and boosting stacked",
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
    comparison: pd.DataFrame,
    by_region: pd.DataFrame,
    fresh: Mapping | None = None,
    noise: Mapping | None = None,
    speed: Mapping | None = None,
    exponents: pd.DataFrame | None = None,
    target: WearTarget | None = None,
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
    comparison : pandas.DataFrame
        From `abradem.learning.comparison.compare`.
    by_region : pandas.DataFrame
        From `abradem.learning.regions.error_by_region`.
    fresh : mapping, optional
        From `abradem.learning.physical.fresh`; None without fresh cases.
    noise : mapping, optional
        From `abradem.learning.physical.noise_floor`; None without simulations.
    speed : mapping, optional
        From `abradem.learning.physical.speed_up`; None without simulations.
    exponents : pandas.DataFrame, optional
        From `abradem.learning.exponents`.
    target : WearTarget, optional
        Target of the study; None if the data set was not simulated.

    Returns
    -------
    list of tuple of str
        Heading and text of each paragraph.
    """
    fixed = sensitivity["held_fixed"]
    found = [
        ("Comparison", _comparison(physical, surrogate, comparison, noise)),
        ("Error by region", _error_by_region(by_region)),
        ("Power law", _power_law(physical)),
        ("Intervals", _intervals(intervals) + _fresh(fresh)),
        ("Learning curve", _curve(curve)),
        ("Extrapolation", _extrapolation(extrapolation, fixed)),
    ]
    if exponents is not None:
        found.insert(3, ("Exponents beside the published data", _exponents(exponents)))
    if physical["repeated"]["rows"]:
        found.insert(0, ("Repeated rows", _repeated(physical["rows"], physical["repeated"])))
    if fixed:
        found.insert(0, ("Held fixed", _held_fixed(fixed)))
    if target is not None:
        found.insert(0, ("Target", f"The models predict the {target.explained}."))
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


def _repeated(rows: int, repeated: Mapping) -> str:
    """The rows that repeat others, counted and named."""
    named = "; ".join(", ".join(map(str, cases)) for cases in repeated["cases"])
    more = repeated["groups"] - len(repeated["cases"])
    others = f"; and {more} more" if more else ""
    return (
        f"{repeated['rows']} of {rows} rows repeat one another, exactly or nearly, in "
        f"{repeated['groups']} groups (case numbers: {named}{others}). Every split and every fold "
        "of the leakage-free protocol keeps a group on one side. The split as published divides "
        "groups, so scores as published count what was learned by heart."
    )


def _comparison(
    physical: Mapping, surrogate: Mapping, comparison: pd.DataFrame, noise: Mapping | None
) -> str:
    scores = {**physical["scores"], "surrogate": surrogate["scores"]}
    names = {**NAMES, "surrogate": "surrogate distilled from the Gaussian process"}
    listed = "; ".join(f"{names[name]} {_score(scores[name]['test']['R2'])}" for name in names)
    text = (
        "R2 of the wear on held-out cases, median over the splits, which are the same for all "
        f"models, and central share of the splits: {listed}."
    )
    if not any(is_number(scores[name]["test"]["R2"]["median"]) for name in names):
        text += " R2 is undefined where the wear of the held-out cases has no spread."
    text += _number_scores(comparison, names)
    if noise is not None and is_number(noise["r2_floor"]):
        best = scores[BEST]["test"]["R2"]["median"]
        text += (
            f" The noise of the simulations limits any model to "
            f"{score_number(noise['r2_floor'], 5)} "
            f"({score_range(noise['r2_floor_band'], 5)}, from {noise['replicates']} simulations "
            f"of {noise['cases']} cases with other seeds; "
            f"{score_number(noise['r2_floor_of_stated_errors'], 5)} from the standard errors of "
            f"the simulations, whose variance is "
            f"{number_or_words(1.0 / noise['ratio'] if noise['ratio'] else None, '.2g')} "
            "times that over the seeds). "
        )
        if is_number(best):
            text += _beside_limit(best, noise)
    return text.strip()


def _beside_limit(best: float, noise: Mapping) -> str:
    """How far the best model is from the limit, an estimate that a median may lie above."""
    gap = noise["r2_floor"] - best
    if gap > 0.0:
        return f"The {NAMES[BEST]} is {gap:.4f} below this limit."
    where = "within" if best <= noise["r2_floor_band"][1] else "above"
    return (
        f"The {NAMES[BEST]} reaches this limit: its median over the splits is {-gap:.4f} above the "
        f"estimate and {where} its band."
    )


def _number_scores(comparison: pd.DataFrame, names: Mapping) -> str:
    """R2 of the logarithm of the wear number, without what the models are given."""
    leakage_free = comparison[comparison["protocol"] == LEAKAGE_FREE].drop_duplicates("model")
    parts = [
        f"{names[row.model]} {score_number(row.r2_number)} "
        f"({score_range((row.r2_number_lower, row.r2_number_upper))})"
        for row in leakage_free.itertuples()
        if row.model in names and is_number(row.r2_number)
    ]
    if not parts:
        return ""
    return (
        " Wear constant, feed and squared speed enter the wear as a factor that these models are "
        f"given. R2 of ln(wear number), the part that they learn: {'; '.join(parts)}."
    )


def _error_by_region(by_region: pd.DataFrame) -> str:
    """Where the best model errs, beside the share of the cases."""
    rows = by_region[by_region["model"] == BEST]
    if rows.empty or not rows["number_error_share"].notna().all():
        return "The error of the wear number is not determined."
    parts = "; ".join(
        f"{row.words} {percentage(row.number_error_share)} of the error of ln(wear number) and "
        f"{percentage(row.error_share)} of that of the wear, with {percentage(row.case_share)} of "
        "the cases"
        for row in rows.itertuples()
    )
    return f"Share of the squared error of the {NAMES[BEST]} on held-out cases: {parts}."


def _intervals(intervals: Mapping) -> str:
    parts = ", ".join(
        f"{100.0 * one['level']:g} %: {percentage(one['coverage'], '.1f')} "
        f"(band {100.0 * one['band'][0]:.1f} to {100.0 * one['band'][1]:.1f}; "
        f"upper end {percentage(one['relative_width'])} above the prediction)"
        for one in intervals["coverage"]
    )
    verdicts = (
        "within" if intervals["in_band"] else "not all within",
        "all" if intervals["within_tolerance"] else "not all",
    )
    return (
        f"Share of {intervals['rows']} held-out cases inside the {intervals['method']} intervals, "
        f"by nominal level: {parts}. They are {verdicts[0]} the binomial bands, and {verdicts[1]} "
        f"within {100.0 * intervals['tolerance']:g} points of the nominal level. By region (angle, "
        f"speed and size) {_by_region(intervals['regions'])}."
    )


def _by_region(verdict: Mapping) -> str:
    """Shares by region that are in their bands, alone and jointly, and what chance does."""
    return (
        f"{verdict['in_band']} of {verdict['shares']} shares are in their binomial bands "
        f"(of intervals that hold exactly, {verdict['expected']:.1f} are on average), and "
        f"{verdict['in_joint']} of {verdict['shares']} in the joint bands, which hold all shares "
        "of such intervals at once in 95 of 100 studies"
    )


def _fresh(fresh: Mapping | None) -> str:
    """The test of the intervals on fresh cases."""
    if fresh is None:
        return ""
    target, *places = fresh["rates"]
    scores = target["scores"]
    text = (
        f" On {fresh['cases']} fresh cases, simulated for this test alone, {_by_region(target)}; "
        f"R2 of the wear is there {score_number(scores['R2'])}, of ln(wear number) "
        f"{score_number(scores['R2_number'])}."
    )
    if places:
        listed = "; ".join(
            f"{WearTarget(one['target']).place} {one['in_band']} of {one['shares']} one by one, "
            f"{one['in_joint']} jointly"
            for one in places
        )
        text += f" Likewise at the other places of the plate: {listed}."
    return text


def _curve(curve: pd.DataFrame) -> str:
    parts = []
    for name, rows in curve.groupby("model", sort=False):
        steps = ", ".join(
            f"{score_number(row.r2)} ({score_number(row.r2_number, 2)}) from {row.trained}"
            for row in rows.itertuples()
        )
        parts.append(f"{NAMES[name]} {steps}")
    return (
        "R2 of the wear (in brackets: of ln(wear number)) by number of training cases: "
        f"{'; '.join(parts)}."
    )


def _extrapolation(extrapolation: pd.DataFrame, fixed: Collection[str]) -> str:
    parts = []
    untested = [test for test in TESTS if test.name not in set(extrapolation["test"])]
    left = [
        f"{test.words}, {HELD_FIXED if test.quantity in fixed else 'too few rows'}"
        for test in untested
    ]
    said = f"Not tested: {'; '.join(left)}." if left else ""
    for words, rows in extrapolation.groupby("words", sort=False):
        best = rows[rows["model"] == BEST].iloc[0]
        others = ", ".join(
            f"{NAMES[row.model]} {score_number(row.r2, 3)} ({score_number(row.r2_number, 2)})"
            for row in rows[rows["model"] != BEST].itertuples()
        )
        parts.append(
            f"{words} ({best['tested']} cases): {NAMES[BEST]} {score_number(best['r2'], 3)} "
            f"({score_number(best['r2_number'], 2)}; trained on such cases as well: "
            f"{score_number(best['within_r2'], 3)}; "
            f"{percentage(best['coverage'])} inside its 95 % intervals), {others}"
        )
    if parts:
        said = (
            "R2 of the wear (in brackets first: of ln(wear number)) on cases beyond the training "
            f"ranges. {'. '.join(parts)}. {said}"
        )
    return said.strip()


def _power_law(physical: Mapping) -> str:
    said = f"{physical['equation']}. The residual scatter is {percentage(physical['scatter'])}."
    told, untold = [], []
    for one in physical["exponents"]:
        name = LABELS[one["term"]].long_name
        if one["variation"] == VARIED:
            told.append(f"{name} {number_with_error(one['exponent'], one['standard_error'])}")
        elif one["variation"] == NOT_IDENTIFIED:
            untold.append(name)
    if told:
        said += f" Exponents of quantities: {', '.join(told)}."
    if untold:
        said += f" {NOT_IDENTIFIED.capitalize()}: {', '.join(untold)}."
    return said


def _exponents(table: pd.DataFrame) -> str:
    """The exponents of the study beside those of the published data, and how many agree."""
    cases = f"{table['rows'].iloc[0]} cases faster than {LEAST_SPEED:g} m/s"
    known = table[table["verdict"] != UNKNOWN]
    if known.empty:
        return f"The {cases} do not determine the exponents of the quantities."
    parts = ", ".join(
        f"{POWER_LABELS[row.quantity].long_name} "
        f"{number_with_error(row.exponent, row.exponent_stderr)} (published "
        f"{number_with_error(row.published_exponent, row.published_stderr)}, {row.verdict})"
        for row in known.itertuples()
    )
    agree = int((known["verdict"] == AGREES).sum())
    return (
        f"Exponents of the wear in the {cases}, beside those of the data that the paper's authors "
        f"published: {parts}. {agree} of {len(known)} agree within {COMBINED_ERRORS:g} combined "
        "standard errors."
    )


def _held_fixed(fixed: Collection[str]) -> str:
    return (
        f"These quantities had the same value in all cases: {_listed(fixed)}. Nothing below is a "
        "statement on their effect, and the models hold for these values alone."
    )


def _score(r2: Mapping) -> str:
    """R2 and its interval over the splits."""
    if not is_number(r2["median"]):
        return score_number(None)
    return f"{score_number(r2['median'])} ({score_range((r2['lower'], r2['upper']))})"


def _speed(speed: Mapping) -> str:
    return (
        f"For the same cases in one job on one core, a simulation takes "
        f"{speed['simulated_seconds']['mean']:.3g} s "
        f"(mean of {len(speed['cases'])} cases with particles of "
        f"{1e3 * min(speed['radii']):.0f} to {1e3 * max(speed['radii']):.0f} mm; "
        f"median {speed['simulated_seconds']['median']:.2g} s) and a prediction "
        f"{1e3 * speed['predicted_seconds']:.2g} ms. A single prediction is "
        f"{_round(speed['speed_up'])} times faster; with {speed['batch']} cases in one call "
        f"({_round(speed['predictions_per_second'])} predictions per second) it is "
        f"{_round(speed['speed_up_of_a_batch'])} times faster."
    )


def _round(value: float) -> str:
    """A number with two digits, in thousands or millions."""
    for size, word in ((1e6, " million"), (1e3, " thousand")):
        if value >= size:
            return f"{float(f'{value / size:.2g}'):g}{word}"
    return f"{float(f'{value:.2g}'):g}"


NUMERALS = ("No", "One", "Two", "Three", "Four")


def _sensitivity(verdict: Mapping, indices: pd.DataFrame, falls: pd.DataFrame) -> str:
    wear = indices[indices["explained"] == "wear"].set_index("feature")
    dominant = verdict["dominant"]
    listed = ", ".join(
        f"{LABELS[name].long_name} ({wear['total'][name]:.2f}; first order "
        f"{wear['first'][name]:.2f})"
        for name in dominant
    )
    varied = int((wear["variation"] == VARIED).sum())
    text = []
    if not dominant:
        text.append(
            "The predicted wear has no spread over the ranges of this data set, so that no Sobol "
            "index is determined." if varied else
            "No quantity varied independently of the others, so that none is ranked."
        )  # fmt: skip
    elif varied > len(dominant):
        text.append(
            f"{NUMERALS[len(dominant)]} quantities explain most of the variance of the wear over "
            f"the ranges of this data set, by total Sobol index: {listed}."
        )
    else:
        text.append(
            "Total Sobol index of the quantities that varied independently, over the ranges of "
            f"this data set: {listed}."
        )
    text += _beside_the_paper(verdict, wear["total"], len(dominant) < varied)
    text += _falls(falls)
    if verdict["hardly_any_effect"]:
        text.append(
            "Hardly any effect (total index of ln wear below 0.01): "
            f"{_listed(verdict['hardly_any_effect'])}."
        )
    for kind, words in (
        ("held_fixed", "Held fixed, hence without a statement on their effect"),
        ("not_identified", "Not identified, as they varied only together with others or the rows "
         "are too few"),
    ):  # fmt: skip
        if verdict[kind]:
            text.append(f"{words}: {_listed(verdict[kind])}.")
    return " ".join(text)


def _beside_the_paper(verdict: Mapping, total: pd.Series, ranked: bool) -> list[str]:
    """Comparison of the dominant quantities with those that the paper names."""
    if verdict["agrees"]:
        return ["They are the four named in the paper."]
    if verdict["agrees"] is None or not ranked:
        untold = [
            name for name in verdict["paper"]
            if name in (*verdict["held_fixed"], *verdict["not_identified"])
        ]  # fmt: skip
        return [
            f"The paper names {_listed(verdict['paper'])}; this study says nothing on "
            f"{_listed(untold)}."
        ] if untold else []  # fmt: skip
    missed = [name for name in verdict["paper"] if name not in verdict["dominant"]]
    new = [name for name in verdict["dominant"] if name not in verdict["paper"]]
    shares = ", ".join(f"{total[name]:.2f}" for name in missed)
    return [
        f"The paper names {len(verdict['shared'])} of them; instead of {_listed(new)} it names "
        f"{_listed(missed)} (total index here: {shares})."
    ]


def _falls(falls: pd.DataFrame) -> list[str]:
    """The quantities whose shuffling costs most."""
    known = falls[(falls["variation"] == VARIED) & falls["fall"].notna()]
    if known.empty:
        return ["The fall of R2 when a quantity is shuffled is not determined."]
    first, *others = known.sort_values("fall", ascending=False).head(4).itertuples(index=False)
    said = (
        f"When shuffled among held-out cases, {LABELS[first.feature].long_name} causes the "
        f"largest fall of R2 ({number_or_words(first.fall, '.2f')})"
    )
    rest = ", ".join(
        f"{LABELS[row.feature].long_name} ({number_or_words(row.fall, '.2f')})" for row in others
    )
    return [f"{said}, followed by {rest}." if rest else f"{said}."]


def _listed(names) -> str:
    return ", ".join(LABELS[name].long_name for name in names)

"""The wear of each part of a surface in sentences, generated from results."""

from __future__ import annotations

import numpy as np
import pandas as pd

from abradem.quantities import wear_column
from abradem.report.findings import to_html
from abradem.wear.part_effects import varied_quantities
from abradem.words.labels import LABELS
from abradem.words.wear import WearTarget

CLEAR = 0.6
"""Rank correlation from which an effect is stated, where it is also more than chance gives."""

CHANCE = 1.96
"""Rank correlations of n cases without an effect are within this times 1 / sqrt(n - 1) in 95 of 100
studies (Spearman 1904; normal approximation)."""

SAME_ORDER = 10.0
"""Factor within which two rates are of the same order of magnitude."""


def parts_page(
    study: str,
    parts: pd.DataFrame,
    effects: pd.DataFrame,
    cases: pd.DataFrame,
    column: str,
    reference: float | None = None,
    source: str | None = None,
    asked: str | None = None,
) -> str:
    """Return the page: what decides the wear of each part, and how much each part wears.

    Parameters
    ----------
    study : str
        Its name.
    parts : pandas.DataFrame
        From `abradem.wear.surface_cells.part_table`.
    effects : pandas.DataFrame
        From `abradem.wear.part_effects.part_effects`.
    cases : pandas.DataFrame
    column : str
        Wear rate, mm/s.
    reference : float, optional
        Rate from elsewhere, mm/s, that the rates of the parts are put beside.
    source : str, optional
        Who states it.
    asked : str, optional
        Part that the study explains; without it the effects on the part that wears most are the
        answer.
    """
    answer = _answer(parts, effects, cases, column, asked)
    if reference is not None and len(parts):
        answer += f" {_beside(parts, column, reference, source)}"
    paragraphs = [("Answer", answer)]
    paragraphs += [
        (f"Part {part}", _part(part, parts, effects, column))
        for part in dict.fromkeys(parts["part_name"])
    ]
    return to_html(f"Wear of the parts in study {study}", paragraphs)


def _answer(
    parts: pd.DataFrame,
    effects: pd.DataFrame,
    cases: pd.DataFrame,
    column: str,
    asked: str | None,
) -> str:
    """Return one sentence on the rates of the parts, and what spares a part."""
    if parts.empty:
        return "No case gave a wear rate."
    means = parts.groupby("part_name", sort=False)[column].mean()
    worst = str(means.idxmax())
    begin = f"Of {len(means)} parts {worst} wears most" if len(means) > 1 else f"{worst} wears"
    others = means.drop(worst).sort_values(ascending=False)
    rest = ", ".join(f"{part} {rate:.3g} mm/s" for part, rate in others.items())
    text = (
        f"{begin}: {means[worst]:.3g} mm/s on average over "
        f"{_count(parts['case_id'].nunique())} ({WearTarget(column).of_part})"
        f"{'; ' if rest else ''}{rest}."
    )
    if asked is not None and len(of_asked := _clear(effects, asked)):
        return " ".join(
            [text, f"Of {asked}:", *(_effect_words(row) for _, row in of_asked.iterrows())]
        )
    of_worst = _clear(effects, worst)
    if len(of_worst):
        return f"{text} {_effect_words(of_worst.iloc[0])}"
    if varied_quantities(cases):
        count = int((parts["part_name"] == worst).sum())
        text += (
            f" No quantity that varied decides it alone (rank correlations below {CLEAR:g}, or no "
            f"more than chance gives in {_count(count)})."
        )
    return text


def _clear(effects: pd.DataFrame, part: str) -> pd.DataFrame:
    """Return the effects on a part that are stated."""
    least = np.maximum(CLEAR, CHANCE / np.sqrt(effects["cases"] - 1.0))
    return effects[(effects["part_name"] == part) & (effects["rank_correlation"].abs() >= least)]


def _beside(parts: pd.DataFrame, column: str, reference: float, source: str | None) -> str:
    """Return two sentences on the rates of the parts beside one from elsewhere.

    Besides the target its 99th percentile over the cells is compared: over which area a rate from
    elsewhere is a mean is often not known.
    """
    target = WearTarget(column)
    columns = {
        name: WearTarget(name).of_cells
        for name in dict.fromkeys((column, wear_column(target.measure, "p99")))
    }
    shares = parts.groupby("part_name", sort=False)[list(columns)].mean() / reference
    shares = shares.sort_values(column, ascending=False)
    each, near = [], []
    for part, row in shares.iterrows():
        each.append(
            f"{part} " + ", ".join(f"{row[name]:.2g} ({words})" for name, words in columns.items())
        )
        near += [
            f"{words} of {part}"
            for name, words in columns.items()
            if 1.0 / SAME_ORDER <= row[name] <= SAME_ORDER
        ]
    by = f" that {source} report" if source else ""
    return (
        f"As multiples of the {reference:.3g} mm/s{by}: {'; '.join(each)}. Within a factor of "
        f"{SAME_ORDER:g} of it: {', '.join(near) or 'none'}."
    )


def _part(part: str, parts: pd.DataFrame, effects: pd.DataFrame, column: str) -> str:
    rows = parts[parts["part_name"] == part]
    rate = rows[column]
    text = (
        f"Area {rows['area'].iloc[0]:.4g} m2; {rate.mean():.3g} mm/s on average over "
        f"{_count(len(rate))}"
    )
    text += f", from {rate.min():.3g} to {rate.max():.3g} mm/s." if len(rate) > 1 else "."
    return " ".join([text, *(_effect_words(row) for _, row in _clear(effects, part).iterrows())])


def _effect_words(row: pd.Series) -> str:
    """Return a sentence on the effect of a quantity."""
    name = str(row["quantity"])
    words = LABELS[name].long_name if name in LABELS else name.replace("_", " ")
    unit = "" if row["unit"] == "1" else f" {row['unit']}"
    verb = "falls" if row["rank_correlation"] < 0.0 else "rises"
    return (
        f"It {verb} with {words} (rank correlation {row['rank_correlation']:.2f}): "
        f"{row['low_rate']:.3g} mm/s {_interval(row['low_from'], row['low_to'])}{unit}, "
        f"{row['high_rate']:.3g} mm/s {_interval(row['high_from'], row['high_to'])}{unit}."
    )


def _interval(low: float, high: float) -> str:
    return f"at {low:.3g}" if low == high else f"from {low:.3g} to {high:.3g}"


def _count(cases: int) -> str:
    return "1 case" if cases == 1 else f"{cases} cases"

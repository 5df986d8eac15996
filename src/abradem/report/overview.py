"""The first screen of the report: the answer, three numbers, a picture, the models, what failed."""

from __future__ import annotations

import base64
import re
from collections.abc import Mapping

import pandas as pd

from abradem.learning.comparison import SPLITS
from abradem.learning.number_text import (
    LOWEST_SCORE,
    UNDETERMINED,
    is_number,
    number_or_words,
    percentage,
    score_number,
    score_range,
)
from abradem.learning.protocols import LEAKAGE_FREE
from abradem.words.escaping import for_html, from_mathtext
from abradem.words.labels import MODELS, ON_GROUPS

MINUS = "\N{MINUS SIGN}"


def overview_page(
    study: str,
    summary: Mapping,
    comparison: pd.DataFrame,
    picture: bytes,
    template: str,
    confidence: float,
    noise: Mapping | None = None,
    surface: str = "an inclined plate",
) -> str:
    """The first screen as a page of its own, which the report contains.

    Parameters
    ----------
    study : str
        Name of the study.
    summary : mapping
        From `abradem.report.summary.study_summary`.
    comparison : pandas.DataFrame
        From `abradem.learning.comparison.compare`.
    picture : bytes
        The figure shown, a PNG file.
    template : str
        The page without its content, workflow/report/overview.html.
    confidence : float
        Share of the splits between the ends of an interval of a score.
    noise : mapping, optional
        From `abradem.learning.physical.noise_floor`; None without simulations.
    surface : str
        What the particles wear, in words.
    """
    models = same_splits(comparison)
    parts = {
        "STUDY": for_html(study),
        "SURFACE": for_html(surface),
        "ANSWER": _whole_numbers(for_html(answer(summary, models, noise))),
        "NUMBERS": "".join(
            f"<div><strong>{for_html(number)}</strong><span>{for_html(words)}</span></div>"
            for number, words in three_numbers(summary, models)
        ),
        "PICTURE": f"data:image/png;base64,{base64.b64encode(picture).decode()}",
        "MODELS": "\n".join(_row(row) for row in models.itertuples()),
        "SPLITS": _splits(models, confidence),
        "FAILED": for_html(what_failed(summary)),
    }
    for key, text in parts.items():
        template = template.replace(f"<!--{key}-->", text)
    return template


def same_splits(comparison: pd.DataFrame) -> pd.DataFrame:
    """Leakage-free scores of all models on the same repeated splits, the best model first."""
    rows = comparison[(comparison["protocol"] == LEAKAGE_FREE) & (comparison["basis"] == SPLITS)]
    return rows.sort_values("r2", ascending=False, kind="stable", ignore_index=True)


def answer(summary: Mapping, models: pd.DataFrame, noise: Mapping | None) -> str:
    """What the study found, in a sentence or two.

    Parameters
    ----------
    summary, noise
        As for `overview_page`.
    models : pandas.DataFrame
        From `same_splits`.
    """
    target = summary["target_words"]
    if models.empty or not is_number(models["r2"].iloc[0]):
        return f"The scores of the models of the {target} are not determined."
    best = models.iloc[0]
    said = (
        f"For cases that it has not seen, the best model, {MODELS[best['model']]}, explains "
        f"{_explained(best['r2'])} of the variance of the {target}"
    )
    others = models[~models["model"].isin(ON_GROUPS)]
    if best["model"] in ON_GROUPS and len(others) and is_number(others["r2"].iloc[0]):
        other = others.iloc[0]
        said += (
            f"; the best one on the features of the paper, {MODELS[other['model']]}, on the "
            f"same splits without leakage, {_explained(other['r2'])}"
        )
    if noise is not None and is_number(noise["r2_floor"]):
        said += (
            f". The noise of the simulations limits any model to {_explained(noise['r2_floor'])}"
        )
        low, high = noise["r2_floor_band"]
        if is_number(low) and is_number(high):
            said += f" ({100.0 * max(low, 0.0):.1f} to {percentage(high, '.1f')})"
            if noise["r2_floor"] < best["r2"] <= high:
                said += ", an interval that holds the score of the best"
    return f"{said}."


def _whole_numbers(text: str) -> str:
    """Text in which no number is divided from its unit, and no name at its hyphens."""
    whole = r"\d[\d.]*(?:-\d+)+|\d[\d.]* (?:%|mm)"
    return re.sub(whole, r'<span class="number">\g<0></span>', text)


def _explained(r2: float) -> str:
    return percentage(r2, ".1f") if r2 > 0.0 else "nothing"


def three_numbers(summary: Mapping, models: pd.DataFrame) -> list[tuple[str, str]]:
    """Three numbers with their words: cases, range of the wear, its error or the best score."""
    low, high = summary["wear_range"]
    wear = (
        f"{_rate(low)} to {_rate(high)} mm/s",
        f"range of the {summary['target_words']}",
    )
    if summary["external"] is not None:
        best = models["r2"].iloc[0] if len(models) else None
        return [
            (str(summary["cases"]), "rows of the table"),
            wear,
            (score_number(best), "R² of the best model on held-out rows"),
        ]
    return [
        (f"{summary['simulated']} of {summary['cases']}", "sampled cases are in the data set"),
        wear,
        (
            percentage(summary["median_relative_stderr"], ".2g"),
            "relative standard error of a rate, median over the cases",
        ),
    ]


def _rate(value: float) -> str:
    """A rate with three digits and, if it is small, a power of ten."""
    mantissa, _, power = number_or_words(value).partition("e")
    return from_mathtext(rf"{mantissa} $\times 10^{{{int(power)}}}$") if power else mantissa


def what_failed(summary: Mapping) -> str:
    """The cases without a rate and those with a quality flag, with the reasons."""
    if summary["external"] is not None:
        return "Nothing was simulated: the data set is an external table."
    failures = summary["failures"]
    said = f"{failures} of {_cases(summary['cases'])} gave no rate"
    if summary["reasons"]:
        said += f" ({_counts(summary['reasons'])}; table failures)"
    flagged = summary["simulated"] - summary["cases_without_flag"]
    said += (
        f". In the data set {_cases(flagged)} {'has' if flagged == 1 else 'have'} a quality flag"
    )
    if summary["flags"]:
        said += f" ({_counts(summary['flags'])})"
    return f"{said}."


def _cases(count: int) -> str:
    return "1 case" if count == 1 else f"{count} cases"


def _counts(found: Mapping[str, int]) -> str:
    return "; ".join(f"{count} × {words}" for words, count in found.items())


def _row(row) -> str:
    kind = "groups" if row.model in ON_GROUPS else "paper"
    known = is_number(row.r2) and row.r2 > LOWEST_SCORE
    unexplained = f"{1.0 - row.r2:.4f}" if known else UNDETERMINED
    numbers = score_number(row.r2), score_range((row.r2_lower, row.r2_upper)), unexplained
    cells = "".join(f"<td>{text.replace('-', MINUS)}</td>" for text in numbers)
    name = for_html(MODELS.get(row.model, row.model))
    return f'<tr class="{kind}"><th scope="row">{name}</th>{cells}</tr>'


def _splits(models: pd.DataFrame, confidence: float) -> str:
    if models.empty:
        return "no repeated splits"
    share = percentage(confidence, "g")
    return f"median and central {share} of {int(models['repeats'].max())} random splits"

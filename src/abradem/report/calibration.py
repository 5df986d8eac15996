"""The outcome of a calibration as sentences, made from its numbers."""

from __future__ import annotations

from collections.abc import Mapping

import pandas as pd

from abradem.calibration.agreement import SCORES
from abradem.learning.number_text import is_number, score_number
from abradem.words.labels import LABELS, MEASURE_WORDS, STATISTIC_WORDS

PARTS = ("used", "held out", "both")
"""Rows that are scored apart, in the order of the text."""

LARGE_SLOPE = 0.3
"""Exponent left in the ratio of given and simulated rates that is named as a difference."""


def sentences(
    summary: Mapping, slopes: pd.DataFrame, profiles: pd.DataFrame, trials: int
) -> list[tuple[str, str]]:
    """Paragraphs on a calibration.

    Parameters
    ----------
    summary : mapping
        From `abradem.calibration.outcome.outcome`.
    slopes, profiles : pandas.DataFrame
        From `abradem.calibration.outcome`.
    trials : int
        Number of set-ups drawn.

    Returns
    -------
    list of tuple of str
        Heading and text of each paragraph.
    """
    return [
        ("Best set-up", _best(summary, trials)),
        ("Agreement", _agreement(summary)),
        ("What the search cannot tell apart", _equal(summary, profiles)),
        ("Exponents", _exponents(slopes)),
    ]


def _best(summary: Mapping, trials: int) -> str:
    values = ", ".join(f"{name} = {value}" for name, value in summary["values"].items())
    size = summary["element_size"]
    of = f" of {1e3 * size:g} mm" if size is not None else ""
    return (
        f"Of {trials} set-ups, trial {summary['trial']} explains the table best: {values}, with "
        f"the measure {summary['measure']} ({MEASURE_WORDS[summary['measure']]}) and the "
        f"statistic {summary['statistic']} ({STATISTIC_WORDS[summary['statistic']]}{of}). "
        "The file best.yaml is a study with it."
    )


def _agreement(summary: Mapping) -> str:
    parts = []
    for name in PARTS:
        of = summary["scores"].get(name)
        if of is None:
            continue
        mean, spread = of["single"]["log_r2"]
        single = (
            f"; a single replicate reaches {mean:.3f} ± {spread:.3f}"
            if is_number(mean) and is_number(spread)
            else ""
        )
        said = {score: score_number(of[score], 3) for score in SCORES}
        parts.append(
            f"{name.capitalize()} ({of['rows']} rows): without a constant R2 of ln y "
            f"{said['log_r2']} and of y {said['r2']}; with one {said['log_r2_constant']} and "
            f"{said['r2_constant']}; the constant is {said['constant']}; rank correlation "
            f"{said['spearman']}{single}."
        )
    return (
        f"Means of {summary['replicates']} replicates. " + " ".join(parts)
        if summary["replicates"] > 1
        else " ".join(parts)
    )


def _equal(summary: Mapping, profiles: pd.DataFrame) -> str:
    count = len(summary["equal_trials"])
    text = (
        "In the last rung no other set-up is as good within two standard errors. "
        if count == 1
        else f"{count} set-ups of the last rung are equal within two standard errors. "
    )
    told, not_told = [], []
    for name, rows in profiles.groupby("unknown", sort=False):
        possible = rows.loc[~rows["told_apart"], "value"]
        if len(possible) == len(rows):
            not_told.append(str(name))
        else:
            told.append(f"{name}: {', '.join(possible)}")
    if told:
        text += "In the first rung these values remain possible: " + "; ".join(told) + ". "
    if not_told:
        text += f"Nothing can be said of {', '.join(not_told)}."
    return text.strip()


def _exponents(slopes: pd.DataFrame) -> str:
    parts, left = [], []
    for row in slopes.itertuples():
        name = LABELS[row.quantity].long_name
        name = f"1 + {name}" if row.quantity == "restitution" else name
        parts.append(
            f"{name} {row.given_exponent:.2f} ± {row.given_stderr:.2f} and "
            f"{row.simulated_exponent:.2f} ± {row.simulated_stderr:.2f}"
        )
        if abs(row.ratio_exponent) > LARGE_SLOPE:
            left.append(f"{name} ({row.ratio_exponent:+.2f} ± {row.ratio_stderr:.2f})")
    if not parts:
        return "There are too few rows for exponents."
    tail = (
        f"More than {LARGE_SLOPE:g} is left against {', '.join(left)}."
        if left
        else f"No exponent above {LARGE_SLOPE:g} is left in their ratio."
    )
    return (
        "Exponents in the table and in the simulation (the squared impact speed v2 + 2 g H counts "
        "as impact speed; angles per 70 and 90 degrees): " + "; ".join(parts) + ". " + tail
    )

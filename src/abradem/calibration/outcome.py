"""What a search found, on rows used and held out, and what it cannot tell apart."""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence

import numpy as np
import pandas as pd

from abradem.calibration.agreement import SCORES, agreement, scored, simulated_means
from abradem.calibration.halving import best_readings, combination
from abradem.calibration.space import Unknown
from abradem.dataset.power_fit import design, wear_exponents
from abradem.quantities import wear_column

BINS = 4
"""Number of parts into which the range of a number is divided for its profile."""

SIGNIFICANT = 2.0
"""Number of standard errors from which two scores differ."""

READING = ("measure", "statistic", "element_size")
"""Unknowns that need no simulation of their own: all are read from one."""


def profiles(
    scores: pd.DataFrame, trials: Sequence[Mapping], space: Sequence[Unknown], by: str
) -> pd.DataFrame:
    """Return the best score for each value of each unknown, whatever the others are.

    A value is told apart from the best one if their scores differ by more than `SIGNIFICANT`
    standard errors of the replicates, or if it has none.

    Parameters
    ----------
    scores : pandas.DataFrame
        Of one rung, from `abradem.calibration.agreement.scored`.
    trials : sequence of mapping
        Values of all set-ups, by number.
    space : sequence of Unknown
    by : str
        The score that decides.

    Returns
    -------
    pandas.DataFrame
        unknown, value (text), low, high (of the part of a range; nan for choices), trials, score,
        noise, told_apart. Values without a score have a score of nan.
    """
    fine = scores[scores[by].notna() & (scores["missing"] == 0)]
    rows = []
    for one in space:
        labels, parts = _parts(one)
        of_trial = {trial: _part(one, trials[trial][one.name], parts) for trial in fine["trial"]}
        groups = fine["trial"].map(of_trial)
        for place, label in enumerate(labels):
            low, high = parts[place] if parts else (np.nan, np.nan)
            rows.append((one.name, label, low, high, *_best(fine[groups == place], by)))
    for name in READING:
        for value in sorted(fine[name].dropna().unique()):
            label = f"{1e3 * value:g} mm" if name == "element_size" else str(value)
            rows.append((name, label, np.nan, np.nan, *_best(fine[fine[name] == value], by)))
    columns = ["unknown", "value", "low", "high", "trials", "score", "noise"]
    found = pd.DataFrame(rows, columns=columns).astype({"trials": "int64"})
    top = found.groupby("unknown")["score"].transform("max")
    of_top = found["noise"].where(found["score"] == top).groupby(found["unknown"]).transform("max")
    # Without replicates the noise is not known (nan), and nothing is told apart.
    error = np.hypot(found["noise"], of_top)
    found["told_apart"] = (top - found["score"] > SIGNIFICANT * error) | found["score"].isna()
    return found


def _parts(one: Unknown) -> tuple[list[str], list[tuple[float, float]]]:
    """Return the labels of the values or parts of an unknown, and the bounds of the parts."""
    if one.choices:
        return [str(value) for value in one.choices], []
    edges = (
        np.geomspace(one.low, one.high, BINS + 1)
        if one.log
        else np.linspace(one.low, one.high, BINS + 1)
    )
    pairs = [(float(low), float(high)) for low, high in itertools.pairwise(edges)]
    return [f"{low:.3g} to {high:.3g}" for low, high in pairs], pairs


def _part(one: Unknown, value, parts: Sequence[tuple[float, float]]) -> int:
    if one.choices:
        return one.choices.index(value)
    return next((at for at, (_, high) in enumerate(parts) if value <= high), len(parts) - 1)


def _best(rows: pd.DataFrame, by: str) -> tuple[int, float, float]:
    if rows.empty:
        return 0, np.nan, np.nan
    best = rows.loc[rows[by].idxmax()]
    return rows["trial"].nunique(), float(best[by]), float(best[f"{by}_noise"])


def equally_good(scores: pd.DataFrame, by: str) -> pd.DataFrame:
    """Return the best readings of the trials that are not told apart from the best one."""
    best = best_readings(scores, by)
    top = best.iloc[0]
    noise = np.hypot(best[f"{by}_noise"].fillna(0.0), np.nan_to_num(top[f"{by}_noise"]))
    return best[top[by] - best[by] <= SIGNIFICANT * noise].reset_index(drop=True)


def outcome(
    rows: pd.DataFrame,
    runs: pd.DataFrame,
    trials: Sequence[Mapping],
    setups: Sequence[Mapping],
    space: Sequence[Unknown],
    by: str,
) -> tuple[dict, pd.DataFrame, pd.DataFrame]:
    """Return what the last rung found.

    Parameters
    ----------
    rows : pandas.DataFrame
        From `abradem.calibration.rows.arranged_rows`.
    runs : pandas.DataFrame
        Of the last rung, on the rows used and held out.
    trials, setups : sequence of mapping
        Values and plain set-ups of all trials, by number.
    space : sequence of Unknown
    by : str
        The score that decides; only rows used count.

    Returns
    -------
    summary : dict
        ``trial``, ``values`` and the reading of the best set-up; ``scores`` on the rows used, held
        out and on both, each with its noise; ``equal``: the values of each unknown among the
        set-ups that are not told apart from the best one.
    predicted : pandas.DataFrame
        case_id, part, given, simulated (mm/s), simulated_stderr (of the mean over replicates) and
        the sampled quantities, of the best set-up.
    slopes : pandas.DataFrame
        quantity; exponent and exponent_stderr of the given rates, of the simulated ones and of
        their ratio.
    """
    given = rows.set_index("case_id")["given"]
    part = rows.set_index("case_id")["part"]
    used = scored(runs[runs["case_id"].map(part) == "used"], given)
    best = best_readings(used, by).iloc[0]
    reading = combination(best)
    trial = int(best["trial"])
    mine = runs[(runs["trial"] == trial)]
    size = mine["element_size"].min() if reading["element_size"] is None else best["element_size"]
    column = wear_column(reading["measure"], reading["statistic"])
    table = simulated_means(mine[mine["element_size"] == size], column)
    replicates = table.drop(columns="mean")
    predicted = rows[rows["case_id"].isin(table.index)].set_index("case_id").loc[table.index]
    count = replicates.shape[1]
    predicted["simulated"] = table["mean"]
    predicted["simulated_stderr"] = (
        replicates.std(axis=1, ddof=1) / np.sqrt(count) if count > 1 else np.nan
    )
    predicted = predicted.reset_index()
    scores = {}
    for name in ("used", "held out", "both"):
        of = ["used", "held out"] if name == "both" else [name]
        here = predicted["part"].isin(of).to_numpy()
        if not here.any():
            continue
        measured = agreement(predicted["given"][here], predicted["simulated"][here])
        singles = [
            agreement(predicted["given"][here], replicates[one].to_numpy()[here])
            for one in replicates
        ]
        scores[name] = {
            "rows": int(here.sum()),
            **measured,
            "single": {
                key: [float(np.mean([s[key] for s in singles])), _spread([s[key] for s in singles])]
                for key in SCORES
            },
        }
    equal = equally_good(used, by)
    summary = {
        "trial": trial,
        "values": dict(trials[trial]),
        **reading,
        "by": by,
        "replicates": count,
        "scores": scores,
        "equal": {
            one.name: sorted({trials[int(number)][one.name] for number in equal["trial"]}, key=str)
            for one in space
        },
        "equal_trials": [int(number) for number in equal["trial"]],
    }
    return summary, predicted, _slopes(predicted, setups[trial])


def trial_table(scores: Sequence[pd.DataFrame], trials: Sequence[Mapping], by: str) -> pd.DataFrame:
    """Return all trials with the last rung that they reached and their best reading there.

    Parameters
    ----------
    scores : sequence of pandas.DataFrame
        Of each rung.
    trials : sequence of mapping
        Values of all set-ups, by number.
    by : str
        The score that decides.

    Returns
    -------
    pandas.DataFrame
        trial, rung (from 1; 0 without a score), values (text), and the columns of
        `abradem.calibration.agreement.scored` for the best reading.
    """
    found = pd.DataFrame(
        {
            "trial": range(len(trials)),
            "values": ["; ".join(f"{k} = {v}" for k, v in one.items()) for one in trials],
        }
    )
    best = pd.concat(
        [best_readings(one, by).assign(rung=rung) for rung, one in enumerate(scores, start=1)],
        ignore_index=True,
    ).drop_duplicates("trial", keep="last")
    found = found.merge(best, on="trial", how="left")
    for name in ("measure", "statistic"):
        found[name] = found[name].fillna("")
    for name in ("rung", "rows", "missing"):
        found[name] = found[name].fillna(0).astype("int64")
    return found.sort_values(
        ["rung", by, "trial"], ascending=[False, False, True], ignore_index=True
    )


def _spread(values: list[float]) -> float:
    return float(np.std(values, ddof=1)) if len(values) > 1 else float("nan")


def _slopes(predicted: pd.DataFrame, setup: Mapping) -> pd.DataFrame:
    """Return the exponents of given, simulated and their ratio side by side."""
    given, simulated = predicted["given"].to_numpy(), predicted["simulated"].to_numpy()
    parts = []
    for name, wear in (("given", given), ("simulated", simulated), ("ratio", given / simulated)):
        fine = np.isfinite(wear) & (wear > 0.0)
        one = wear_exponents(predicted[fine], wear[fine], setup).rename(
            columns={"exponent": f"{name}_exponent", "exponent_stderr": f"{name}_stderr"}
        )
        parts.append(one.set_index("quantity"))
    found = pd.concat(parts, axis=1).reset_index()
    order = {name: place for place, name in enumerate(design(predicted, setup))}
    return found.sort_values("quantity", key=lambda column: column.map(order), ignore_index=True)

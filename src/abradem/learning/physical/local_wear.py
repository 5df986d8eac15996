"""Wear at other places of the plate than that of the target, for the surrogate.

A lining fails where it is thinnest, while its mean says how much material is lost. So the surrogate
answers the mean over the plate, the mean over the footprint, the 99th percentile and the worst
element, of the wear measure of the target. Each has a Gaussian process of its own on the same
dimensionless groups, distilled as that of the target is (`abradem.learning.physical.distil`), and
conformal intervals of its own held-out errors.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
import pandas as pd

from abradem.learning.physical.distil import Settings, distil
from abradem.learning.physical.intervals import INNER_FOLDS, conformal_of, hold_out_in_turn
from abradem.learning.physical.models import PROCESS, fitted, makers
from abradem.learning.physical.problem import WearProblem, problem
from abradem.learning.scores import has_spread, score
from abradem.quantities import wear_column, wear_parts
from abradem.surrogate.groups import Jet
from abradem.surrogate.parts import local_prefix

LOCAL_STATISTICS = ("mean", "footprint", "p99", "max")
"""Statistics over the plate that a surrogate answers."""


SCALING = ("group_mean", "group_scale")


NOT_BELOW = {"footprint": "mean", "max": "p99"}
"""The statistic that one cannot be below, by definition: the footprint is the smallest part of the
plate that holds its share of the wear, and nothing is worn deeper than the worst element."""


class LocalWear(NamedTuple):
    """What the surrogate of a study holds besides its target.

    Attributes
    ----------
    descriptions : list of dict
        ``target``, ``training_rows``, ``distillation_error`` and ``held_out``, the scores of the
        Gaussian process on rows that were held out in turn.
    arrays : dict of str to ndarray
        Networks and held-out errors, whose names begin with
        `abradem.surrogate.parts.local_prefix`, and the scaling of the groups.
    """

    descriptions: list[dict]
    arrays: dict[str, np.ndarray]


def local_targets(dataset: pd.DataFrame, target: str) -> list[str]:
    """Wear rates of the measure of ``target`` that the data set holds and that vary, without it."""
    measure, _ = wear_parts(target)
    columns = [wear_column(measure, statistic) for statistic in LOCAL_STATISTICS]
    return [
        name
        for name in columns
        if name != target
        and name in dataset
        and (dataset[name] > 0.0).any()
        and has_spread(dataset[name].to_numpy(dtype=float))
    ]


def local_wear(
    dataset: pd.DataFrame,
    jet: Jet,
    target: str,
    name: str = "dataset",
    settings: Settings | None = None,
    fold_count: int = INNER_FOLDS,
    seed: int = 0,
    element_size: float | None = None,
) -> LocalWear:
    """Train the models of the other places of the plate.

    Parameters
    ----------
    dataset : pandas.DataFrame
        See `abradem.learning.physical.problem.problem`.
    jet : Jet
    target : str
        Target of the study, which is left out.
    name : str
        Name of the data set.
    settings : Settings, optional
        Of the distillation.
    fold_count : int
        Folds in which the rows are held out.
    seed : int
    element_size : float, optional
        Edge of the elements, m; not noted for the mean over the plate.
    """
    descriptions, arrays = [], {}
    for other in local_targets(dataset, target):
        given = problem(dataset, jet, other, name)
        described, found = _one(given, settings or Settings(), fold_count, seed)
        if element_size is not None and wear_parts(other)[1] != "mean":
            described["target"]["element_size"] = element_size
        descriptions.append(described)
        for key, array in found.items():
            # The groups are scaled as for the target, from the same points.
            arrays[key if key in SCALING else f"{local_prefix(other)}{key}"] = array
    return LocalWear(descriptions, arrays)


def _one(
    given: WearProblem, settings: Settings, fold_count: int, seed: int
) -> tuple[dict, dict[str, np.ndarray]]:
    """Description and arrays of one wear rate."""
    rows = np.arange(len(given.log_number))
    process = fitted(makers(seed)[PROCESS], given, rows)
    held = hold_out_in_turn(given, rows, fold_count, seed)
    conformal = conformal_of(given, rows, held)
    arrays, error = distil(process, given, settings, seed, conformal.scale)
    actual = given.table.target
    return {
        "target": {"name": given.table.target_name, "unit": given.table.unit},
        "training_rows": len(rows),
        "raised": given.raised,
        "distillation_error": error,
        "error_scale": conformal.scale.describe(),
        "held_out": score(actual, given.wear(rows, held.mean), float(actual.min())),
    }, {**arrays, "conformal": conformal.scores}


def with_meaning(
    model: tuple[dict, dict[str, np.ndarray]],
    jet_known: bool,
    target_known: bool,
    cells: bool = False,
    part: str | None = None,
    contacts: Mapping | None = None,
) -> tuple[dict, dict[str, np.ndarray]]:
    """Description and arrays of a surrogate that says whether its jet and target are known.

    Of a table from elsewhere they may not be. The numbers of the jet are then a reference with
    which the groups are computed, and the names of the wear rates those of their columns alone.

    Parameters
    ----------
    model : pair
    jet_known, target_known : bool
    cells, part
        See `abradem.words.wear.WearTarget`; noted for a geometry alone.
    contacts : mapping, optional
        ``pair_interaction`` of the simulations: restitution, static_friction and rolling_friction
        of two particles, or None where they meet each other as they meet the plate.
    """
    description, arrays = model
    place = {**({"cells": True} if cells else {}), **({"part": part} if part else {})}

    def said(one: dict) -> dict:
        return {**one, "target": {**one["target"], "known": target_known, **place}}

    local = [said(one) for one in description.get("local", [])]
    found = {**said(description), "jet_known": jet_known, "local": local, **(contacts or {})}
    return found, arrays


def with_local_wear(
    model: tuple[dict, dict[str, np.ndarray]], local: LocalWear
) -> tuple[dict, dict[str, np.ndarray]]:
    """Description and arrays of a surrogate with those of the other places of the plate.

    The models are fitted one by one, so that each says what it cannot be below (`NOT_BELOW`).

    Parameters
    ----------
    model : pair
        From `abradem.learning.physical.distil.surrogate_of`, for the same rows, settings and seed.
    local : LocalWear

    Raises
    ------
    ValueError
        If the groups are scaled in another way, as those of other rows or of another seed are.
    """
    description, arrays = model
    if not all(np.array_equal(arrays[key], local.arrays.get(key, arrays[key])) for key in SCALING):
        raise ValueError("local wear and surrogate do not scale the groups in the same way")
    rates = [dict(one) for one in (description, *local.descriptions)]
    names = [one["target"]["name"] for one in rates]
    for one in rates:
        measure, statistic = wear_parts(one["target"]["name"])
        floor = wear_column(measure, NOT_BELOW[statistic]) if statistic in NOT_BELOW else None
        if floor in names:
            one["at_least"] = floor
    return {**rates[0], "local": rates[1:]}, {**arrays, **local.arrays}

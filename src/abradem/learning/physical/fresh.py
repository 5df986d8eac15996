"""Test of the prediction intervals on fresh cases, simulated for nothing else.

Held-out rows of a study are few in each region, and were seen by the developer of its models. Fresh
cases come from blocks that no model has seen. The surrogate, as `abradem predict` uses it, predicts
them with intervals, at every place of the plate that it knows. The share inside is compared with
the bands of each region (`abradem.learning.physical.region_coverage`).
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
import pandas as pd

from abradem.learning.physical.intervals import REPORTED
from abradem.learning.physical.problem import WearProblem
from abradem.learning.physical.region_coverage import (
    coverage_by_region,
    faultless,
    faultless_on_new,
    joint_summary,
    with_joint_bands,
)
from abradem.learning.regions import Region, regions_of
from abradem.learning.scores import r2, score
from abradem.quantities import SAMPLED_NAMES
from abradem.surrogate.groups import input_names
from abradem.surrogate.model import Surrogate, highest_level

EVERYWHERE = Region("all", "all cases", SAMPLED_NAMES[0], 0.0, np.inf)


def coverage_of_fresh(
    surrogate: Surrogate, rates: Iterable[tuple[WearProblem, WearProblem]]
) -> tuple[pd.DataFrame, dict]:
    """Coverage of the intervals of a surrogate, and its scores, on fresh cases.

    Parameters
    ----------
    surrogate : Surrogate
    rates : iterable of pair of WearProblem
        For each wear rate of the surrogate the rows of the study, whose ranges divide the regions,
        and the fresh cases.

    Returns
    -------
    coverage : pandas.DataFrame
        ``target``, the wear rate, and the columns of
        `abradem.learning.physical.region_coverage.with_joint_bands`; the first rows of each wear
        rate are of all cases. Levels that its held-out errors cannot promise are left out.
    summary : dict
        ``cases``, and ``rates``, a list with, for each wear rate: ``target``; ``all``, level,
        coverage, band and whether it is in it, over all cases; the verdict on the shares by region,
        see `abradem.learning.physical.region_coverage.joint_summary`; ``scores``, the metrics of
        `abradem.learning.scores.score` and ``R2_number``.
    """
    tables, summaries = zip(*(_of_one(surrogate, *pair) for pair in rates), strict=True)
    coverage = pd.concat(tables, ignore_index=True)
    return coverage, {"cases": int(coverage["tested"].max()), "rates": list(summaries)}


def _of_one(
    surrogate: Surrogate, given: WearProblem, fresh: WearProblem
) -> tuple[pd.DataFrame, dict]:
    """Coverage and scores of one wear rate."""
    target = fresh.table.target_name
    values = dict(zip(input_names(fresh.jet), fresh.inputs.T, strict=True))
    y = fresh.table.target
    known = surrogate.model(target).score_count
    highest = highest_level(known)
    inside = {}
    for level in REPORTED:
        if level <= highest:
            found = surrogate.predict(values, level, target)
            inside[level] = (y >= found.lower) & (y <= found.upper)
    rate = surrogate.predict(values, target=target).rate
    regions = regions_of(given.inputs)
    joint = faultless(faultless_on_new(known, len(y)), list(inside), fresh.inputs, regions)
    coverage = with_joint_bands(
        coverage_by_region(inside, fresh.inputs, [EVERYWHERE, *regions]), joint
    )
    overall = coverage["region"] == EVERYWHERE.name
    parts = coverage[~overall]
    return coverage.assign(target=target)[["target", *coverage.columns]], {
        "target": target,
        "all": [
            {
                "level": row.level,
                "coverage": row.coverage,
                "band": [row.band_lower, row.band_upper],
                "in_band": bool(row.in_band),
            }
            for row in coverage[overall].itertuples(index=False)
        ],
        **joint_summary(parts, joint),
        "scores": {
            **score(y, rate, float(given.table.target.min())),
            "R2_number": r2(fresh.log_number, np.log(rate / fresh.scale)),
        },
    }

"""Test of the prediction intervals on fresh cases, simulated for nothing else.

Held-out rows of a study are few in each region, and were seen by the developer of its models. Fresh
cases come from blocks that no model has seen. The surrogate, as `abradem predict` uses it, predicts
them with intervals, and the share inside is compared with the binomial band of each region.
"""

from __future__ import annotations

import numpy as np
import pandas as pd

from abradem.learning.physical.intervals import REPORTED, coverage_by_region
from abradem.learning.physical.problem import WearProblem
from abradem.learning.regions import Region, regions_of
from abradem.learning.scores import r2, score
from abradem.quantities import SAMPLED_NAMES
from abradem.surrogate.groups import input_names
from abradem.surrogate.model import Surrogate

EVERYWHERE = Region("all", "all cases", SAMPLED_NAMES[0], 0.0, np.inf)


def coverage_of_fresh(
    surrogate: Surrogate, given: WearProblem, fresh: WearProblem
) -> tuple[pd.DataFrame, dict]:
    """Coverage of the intervals of a surrogate, and its scores, on fresh cases.

    Parameters
    ----------
    surrogate : Surrogate
    given : WearProblem
        The rows of the study, whose ranges divide the regions.
    fresh : WearProblem
        The fresh cases.

    Returns
    -------
    coverage : pandas.DataFrame
        See `abradem.learning.physical.intervals.coverage_by_region`; the first rows are of all
        cases. Levels that the surrogate cannot promise are left out.
    summary : dict
        ``cases``; ``shares``, the number of rows of the coverage by region, and ``in_band``, how
        many are in their band; ``scores``, the metrics of `abradem.learning.scores.score` and
        ``R2_number``.
    """
    values = dict(zip(input_names(fresh.jet), fresh.inputs.T, strict=True))
    y = fresh.table.target
    inside = {}
    for level in REPORTED:
        if level <= surrogate.highest_confidence:
            found = surrogate.predict(values, level)
            inside[level] = (y >= found.lower) & (y <= found.upper)
    rate = surrogate.predict(values).rate
    regions = [EVERYWHERE, *regions_of(given.inputs)]
    coverage = coverage_by_region(inside, fresh.inputs, regions)
    parts = coverage[coverage["region"] != EVERYWHERE.name]
    return coverage, {
        "cases": len(y),
        "shares": len(parts),
        "in_band": int(parts["in_band"].sum()),
        "scores": {
            **score(y, rate, float(given.table.target.min())),
            "R2_number": r2(fresh.log_number, np.log(rate / fresh.scale)),
        },
    }

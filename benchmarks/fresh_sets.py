"""Prediction intervals and R2 over training sets: on average, and how much they vary.

    snakemake coverage --configfile config.yaml studies/fresh_cases.yaml
    python benchmarks/fresh_sets.py config.yaml studies/fresh_cases.yaml
    python benchmarks/fresh_sets.py config.yaml studies/dilute.yaml studies/tenfold.yaml \
        --trained 200 800 --divisions 4 --tested 1000 --targets wear_total_mean

A study and its fresh cases are one division of the same cases. Here they are divided at random,
again and again, into cases to learn from (as many as the study has, or as ``--trained`` says) and
200 of the others (or as many as ``--tested`` says); the Gaussian process and its conformal
intervals, without the distillation, are fitted to the former. As for fresh cases of a study, the
shares of the latter inside their intervals are compared with the binomial band of each region.

Not all shares of faultless intervals are in their band. The quantile of an interval rests on as
many held-out errors as there are cases to learn from, so that its true level scatters (Vovk 2012,
JMLR W&CP 25:475), and the binomial band knows of the scatter of the new cases alone. How many
shares would be in their band is therefore drawn for scores that depend on nothing, and so are
the joint bands of all shares (`abradem.learning.physical.region_coverage`).
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np
import pandas as pd

from abradem.config import read_config, setup_dict
from abradem.learning.physical.intervals import (
    REPORTED,
    conformal_of,
    hold_out_in_turn,
)
from abradem.learning.physical.models import PROCESS, fitted, makers
from abradem.learning.physical.problem import WearProblem, problem
from abradem.learning.physical.region_coverage import (
    coverage_by_region,
    faultless,
    faultless_on_new,
    joint_summary,
    with_joint_bands,
)
from abradem.learning.regions import regions_of
from abradem.learning.scores import r2
from abradem.store.tables import read_table
from abradem.surrogate.groups import jet_of


def one_division(given: WearProblem, train: np.ndarray, test: np.ndarray, folds: int, seed: int):
    """What a training set gives on the test rows.

    Returns
    -------
    inside : list of float
        Share of the test rows inside the intervals of each level of `REPORTED`.
    table : pandas.DataFrame
        The shares by region, see `abradem.learning.physical.region_coverage.coverage_by_region`.
    verdict : dict
        On the shares by region, see `abradem.learning.physical.region_coverage.joint_summary`.
    scores : list of float
        R2 of the wear and of the logarithm of the wear number.
    """
    process = fitted(makers(seed)[PROCESS], given, train)
    mean, deviation = process.predict_with_deviation(given.groups[test])
    intervals = conformal_of(given, train, hold_out_in_turn(given, train, folds, seed))
    away = np.abs(given.log_number[test] - mean) / deviation
    inside = {level: away <= intervals.half(given.groups[test], level) for level in REPORTED}
    regions, draw = regions_of(given.inputs[train]), faultless_on_new(len(train), len(test))
    joint = faultless(draw, REPORTED, given.inputs[test], regions)
    table = with_joint_bands(coverage_by_region(inside, given.inputs[test], regions), joint)
    scores = [
        r2(given.table.target[test], given.wear(test, mean)),
        r2(given.log_number[test], mean),
    ]
    shares = [float(inside[level].mean()) for level in REPORTED]
    return shares, table, joint_summary(table, joint), scores


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("files", nargs="+", help="configuration of a study")
    parser.add_argument("--divisions", type=int, default=12)
    parser.add_argument("--trained", type=int, nargs="+", help="numbers of cases to learn from")
    parser.add_argument("--tested", type=int, default=200, help="number of the others")
    parser.add_argument("--targets", nargs="+", default=["wear_friction_p99", "wear_friction_mean"])
    asked = parser.parse_args()
    config = read_config(*asked.files)
    folder = Path("results", config.study)
    paths = [folder / part / "dataset.parquet" for part in ("", "fresh")]
    tables = [read_table(path) for path in paths if path.is_file()]
    rows = pd.concat(tables, ignore_index=True)
    sizes = asked.trained or [len(tables[0])]
    tested = asked.tested
    if max(sizes) + tested > len(rows):
        parser.error(f"--trained {max(sizes)}: {len(rows)} cases leave fewer than {tested} to test")
    folds = config.learning.physical.interval_folds
    for target in asked.targets:
        given = problem(rows, jet_of(setup_dict(config)), target)
        for size in sizes:
            inside, regions, verdicts, scores = [], [], [], []
            for division in range(asked.divisions):
                order = np.random.default_rng(division).permutation(len(rows))
                train, test = np.sort(order[tested:][:size]), np.sort(order[:tested])
                found = one_division(given, train, test, folds, config.seed)
                for kept, one in zip((inside, regions, verdicts, scores), found, strict=True):
                    kept.append(one)
            in_band, expected, shares = (
                np.array([one[key] for one in verdicts])
                for key in ("in_band", "expected", "shares")
            )
            whole = np.sum([one["in_joint"] == one["shares"] for one in verdicts])
            print(
                f"{target}, {size} cases to learn from, {asked.divisions} divisions: "
                f"{in_band.mean():.1f} of {shares.max()} shares by region in their band "
                f"({in_band.min()} to {in_band.max()}; faultless intervals {expected.mean():.1f}); "
                f"all in their joint bands in {whole} of {asked.divisions}"
            )
            share = 100.0 * np.array(inside)
            for place, level in enumerate(REPORTED):
                one = share[:, place]
                print(
                    f"  {100 * level:g} %: {one.mean():.1f} % of the test cases inside, "
                    f"{one.min():.1f} to {one.max():.1f}"
                )
            for name, of in pd.concat(regions).groupby("region", sort=False):
                count = of.groupby("level")["tested"].mean().iloc[0]
                share = [
                    f"{100 * np.average(one['coverage'], weights=one['tested']):.1f}"
                    for _, one in of.groupby("level")
                ]
                print(f"  {name} ({count:.0f} cases): {', '.join(share)} % inside")
            for words, of in zip(
                ("the wear", "ln(wear number)"), np.transpose(scores), strict=True
            ):
                ends = f"{of.min():.4f} to {of.max():.4f}"
                print(f"  R2 of {words}: median {np.median(of):.4f}, {ends}", flush=True)


if __name__ == "__main__":
    main()

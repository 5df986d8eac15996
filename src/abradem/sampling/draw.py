"""Parameter sets to simulate: drawn in blocks, checked for physical consistency.

A block is a pure function of the seed of the study and the index of the block. A study can
therefore be enlarged by more blocks without a change of earlier cases. With the method ``lhs``
each block is a separate Latin hypercube (McKay, Beckman & Conover 1979, Technometrics 21:239);
with ``sobol`` the blocks are successive parts of one Sobol sequence.
"""

from __future__ import annotations

import hashlib
import warnings
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from abradem.quantities import GEOMETRY_UNITS, SAMPLED_NAMES
from abradem.sampling.checks import check_case

if TYPE_CHECKING:
    import pandas as pd

    from abradem.dem.model import Setup

METHODS = ("lhs", "sobol", "uniform")


_SEED_TAG = b"abradem case seed 1"


def block_cases(
    seed: int,
    block: int,
    cases_per_block: int,
    method: str,
    ranges: Mapping[str, Sequence[float]],
    setup: Setup | None = None,
    geometry: Mapping[str, Sequence[float]] | None = None,
) -> pd.DataFrame:
    """Draw one block of cases.

    Parameters
    ----------
    seed : int
        Seed of the study.
    block : int
        Index of the block.
    cases_per_block : int
    method : {"lhs", "sobol", "uniform"}
    ranges : mapping of str to (float, float)
        Lower and upper bound of each sampled quantity, in the units of `abradem.quantities`; a
        quantity with equal bounds is fixed.
    setup : Setup, optional
        If given, each parameter set is also checked against it, see `check_case`.
    geometry : mapping of str to (float, float), optional
        Lower and upper bound of the sampled quantities of the geometry, of
        `abradem.quantities.GEOMETRY_UNITS`; they are further dimensions of the draw.

    Returns
    -------
    pandas.DataFrame
        One row per case: ``case_id``, ``block``, ``seed``, the sampled quantities and
        ``rejected``, which is empty or the reason why the case cannot be simulated. A rejected
        case keeps its ``case_id``.

    Raises
    ------
    ValueError
        If a range is missing, unknown or not finite, or the method is unknown.
    """
    import pandas as pd

    extra = dict(geometry or {})
    missing = [name for name in SAMPLED_NAMES if name not in ranges]
    unknown = [name for name in ranges if name not in SAMPLED_NAMES]
    unknown += [name for name in extra if name not in GEOMETRY_UNITS]
    if missing or unknown:
        raise ValueError(f"ranges: missing {missing}, unknown {unknown}")
    names = (*SAMPLED_NAMES, *extra)
    lower, upper = np.array([{**ranges, **extra}[name] for name in names], dtype=float).T
    if not (np.isfinite(lower).all() and np.isfinite(upper).all() and (lower <= upper).all()):
        raise ValueError("ranges: bounds must be finite, the lower not above the upper")

    points = _unit_points(seed, block, cases_per_block, method, len(names))
    # Rounding must not move a value beyond its bound.
    values = np.clip(lower + points * (upper - lower), lower, upper)

    case_id = block * cases_per_block + np.arange(cases_per_block, dtype=np.int64)
    frame = pd.DataFrame(
        {
            "case_id": case_id,
            "block": np.full(cases_per_block, block, dtype=np.int32),
            "seed": np.array([case_seed(seed, int(case)) for case in case_id], dtype=np.int64),
            **dict(zip(names, values.T, strict=True)),
        }
    )
    rows = frame[list(names)].to_dict("records")
    frame["rejected"] = pd.array([check_case(row, setup) for row in rows], dtype="str")
    return frame


def case_seed(study_seed: int, case_id: int) -> int:
    """Return the seed of a case: 63 bits of a hash, so seeds of neighbours are unrelated."""
    digest = hashlib.sha256(_SEED_TAG + f" {study_seed} {case_id}".encode()).digest()
    return int.from_bytes(digest[:8], "little") >> 1


def _unit_points(seed: int, block: int, cases: int, method: str, dimensions: int) -> np.ndarray:
    """Return points in the unit cube, shape (cases, dimensions)."""
    if method == "uniform":
        return _generator(seed, block).random((cases, dimensions))
    from scipy.stats import qmc

    if method == "lhs":
        return qmc.LatinHypercube(dimensions, rng=_generator(seed, block)).random(cases)
    if method == "sobol":
        # All blocks are parts of one sequence. If each were scrambled separately, their points
        # would be reflections of each other instead of filling the gaps.
        sequence = qmc.Sobol(dimensions, scramble=True, rng=_generator(seed, 0))
        if block:
            sequence.fast_forward(block * cases)
        with warnings.catch_warnings():
            # The documentation states that it is balanced only for powers of two.
            warnings.filterwarnings("ignore", "The balance properties", UserWarning)
            return sequence.random(cases)
    raise ValueError(f"method = {method!r} is unknown; allowed: {', '.join(METHODS)}")


def _generator(seed: int, block: int) -> np.random.Generator:
    return np.random.default_rng(np.random.SeedSequence(seed, spawn_key=(block,)))

"""An external table, used instead of simulations.

`abradem.dataset.user_table` reads the table, finds its columns and converts their units. Units are
those of `abradem.quantities` unless the mapping, the name of the column or the metadata of a
Parquet field names another. Values outside the physical limits, the typical result of a wrong
unit, are rejected. Derived features that are missing are computed. Those in the table are used
unchanged (the published table rounds Young's modulus of the plate, for example) unless they
contradict their formula. A data set written by this package is also a valid table.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pandas as pd

from abradem.dataset.features import contact_damping, derive
from abradem.dataset.known_names import PUBLISHED_NAMES
from abradem.dataset.user_table import (
    Found,
    capped,
    column_values,
    find_columns,
    plain_numbers,
    read_user_table,
    repeated_rows,
    similar_columns,
)
from abradem.elastic import effective_youngs_modulus, sphere_mass
from abradem.quantities import (
    FEATURE_NAMES,
    QUANTITIES,
    SAMPLED_NAMES,
    TARGET,
    WEAR_COLUMNS,
    quantity,
)
from abradem.store.files import TableError

CLOSE = 0.05
"""Relative difference up to which a derived value agrees with its formula, as for two digits."""
LARGEST_KEY = 2**53
"""Largest case number: case numbers are read as floating-point numbers, exact up to here."""
Mapped = Mapping[str, str | tuple[str, str]]


def read_external(
    path: str | Path, columns: Mapped | None = None, damping_coefficient: str = "table"
) -> pd.DataFrame:
    """Read a user's table as a data set.

    Parameters
    ----------
    path : path-like
        ``.csv`` or ``.parquet``, see `abradem.dataset.user_table.read_user_table`.
    columns : mapping, optional
        Column of the table, or a pair of column and unit, for names of this package.
    damping_coefficient : {"table", "printed"}
        Form of X20 if the table lacks it, see `abradem.dataset.features`.

    Returns
    -------
    pandas.DataFrame
        case_id (from the table if it has such a column, otherwise the row number from 0), the 20
        features, and the wear columns of the table.

    Raises
    ------
    TableError
        With one line for each problem.
    """
    table = read_user_table(path)
    columns = dict(columns or {})
    wanted = (*FEATURE_NAMES, *WEAR_COLUMNS)
    problems = [
        f"{path}: mapping of {name}: no such quantity; known are {', '.join(wanted)}"
        for name in columns
        if name not in wanted
    ]
    places, faulty = find_columns(table, wanted, columns)
    problems += [f"{path}: {line}" for line in faulty.values()]
    found: dict[str, np.ndarray] = {}
    for name, place in places.items():
        found[name], lines = column_values(table, name, place)
        problems += [f"{path}: {line}" for line in lines]
    taken = [place.column for place in places.values()]
    for name in SAMPLED_NAMES:
        if name in found or name in faulty:
            continue
        similar = similar_columns(table, name, taken)
        hint = f"; is it {' or '.join(map(repr, similar))}?" if similar else ""
        problems.append(
            f"{path}: lacks a column for {name} (looked for {name}, {PUBLISHED_NAMES[name]}; "
            f"map it with dataset.columns{hint})"
        )
    if not any(name in found or name in faulty for name in WEAR_COLUMNS):
        problems.append(
            f"{path}: lacks a wear rate (looked for {', '.join(WEAR_COLUMNS[:1])}, "
            f"{PUBLISHED_NAMES[TARGET.name]}; map it with dataset.columns)"
        )
    keys, problem = _keys(table.frame)
    if problem:
        problems.append(f"{path}: {problem}")
    if problems:
        raise TableError("\n".join(problems))
    problems = [f"{path}: {line}" for line in _bad_rows(found, places)]
    if problems:
        raise TableError("\n".join(problems))

    given = pd.DataFrame(found)
    derived = derive(given)
    problems = [f"{path}: {line}" for line in _wrong_derived(given, derived)]
    if problems:
        raise TableError("\n".join(problems))
    for name, values in _missing_derived(given, derived, damping_coefficient).items():
        given[name] = values
    given.insert(0, "case_id", keys)
    wear = [name for name in WEAR_COLUMNS if name in given]
    return given[["case_id", *FEATURE_NAMES, *wear]]


def repeated(dataset: pd.DataFrame) -> str:
    """Return one line on the rows of a data set that repeat the quantities of another, or ""."""
    return repeated_rows({name: dataset[name].to_numpy() for name in SAMPLED_NAMES})


def _keys(table: pd.DataFrame) -> tuple[np.ndarray, str]:
    """Return the case numbers of the rows, and the problem with them or ""."""
    if "case_id" not in table:
        return np.arange(len(table), dtype=np.int64), ""
    values, bad = plain_numbers(table["case_id"])
    if bad.any() or (values != np.rint(values)).any() or len(set(values)) < len(values):
        return values, "column 'case_id': must contain whole numbers, each once"
    if (np.abs(values) > LARGEST_KEY).any():
        return values, f"column 'case_id': contains numbers beyond {LARGEST_KEY}"
    return values.astype(np.int64), ""


def _bad_rows(found: dict[str, np.ndarray], places: Mapping[str, Found]) -> list[str]:
    """Return lines on values outside the physical limits, and on wear that is not positive."""
    lines = []
    for name, values in found.items():
        if name in SAMPLED_NAMES:
            row = quantity(name)
            low, high = row.limits
            bad = np.flatnonzero((values < low) | (values > high))
            law = f"must lie in [{low:g}, {high:g}] {row.unit}"
            unit = "" if row.unit == "1" else f" {row.unit}"
        elif name == TARGET.name:
            bad, law, unit = np.flatnonzero(values <= 0.0), "must be positive", " mm/s"
        elif name in WEAR_COLUMNS and not name.startswith("wear_friction"):
            bad, law, unit = np.flatnonzero(values < 0.0), "must not be negative", " mm/s"
        else:
            continue
        named = "" if places[name].column == name else f" (column {places[name].column!r})"
        if len(bad) > 1 and len(bad) == len(values):
            lines.append(
                f"column {name}{named}: all {len(values)} values are out of limits (first "
                f"{values[0]:g}{unit}), {law}; give its unit with dataset.columns"
            )
        else:
            lines += [f"row {at + 1}: {name}{named} = {values[at]:g}{unit} {law}" for at in bad]
    return capped(lines)


def _wrong_derived(given: pd.DataFrame, derived: pd.DataFrame) -> list[str]:
    """Return lines on derived values that contradict their formula, due to wrong units or signs."""
    lines = []
    for row in QUANTITIES:
        if row.kind != "derived" or row.name not in given:
            continue
        values, formula = given[row.name].to_numpy(), derived[row.name].to_numpy()
        # The damping coefficient exists in two forms, see `abradem.dataset.features`.
        forms = (1.0, -math.sqrt(6.0 / 5.0)) if row.name == "damping_coefficient" else (1.0,)
        expected = min(
            (form * formula for form in forms), key=lambda e: np.median(np.abs(values - e))
        )
        bad = np.flatnonzero(np.abs(values - expected) > CLOSE * np.abs(expected))
        if 2 * len(bad) > len(values):
            ratio = np.median(values[bad] / formula[bad])
            lines.append(
                f"column {row.name}: is {ratio:.3g} times the value of its formula (median of the "
                "rows); check its unit and its sign"
            )
        else:
            lines += [
                f"row {at + 1}: {row.name} = {values[at]:g} contradicts its formula, which gives "
                f"{expected[at]:g}"
                for at in bad
            ]
    return capped(lines)


def _missing_derived(
    given: pd.DataFrame, derived: pd.DataFrame, damping_coefficient: str
) -> dict[str, pd.Series]:
    """Return the derived features that the table lacks, computed from those that it has."""
    known = {
        name: given[name] if name in given else derived[name]
        for name in ("particle_youngs_modulus", "equipment_youngs_modulus", "damping_ratio")
    }
    star = effective_youngs_modulus(
        known["particle_youngs_modulus"],
        given["particle_poisson_ratio"],
        known["equipment_youngs_modulus"],
        given["equipment_poisson_ratio"],
    )
    known["effective_youngs_modulus"] = given.get("effective_youngs_modulus", star)
    mass = sphere_mass(given["particle_radius"], given["particle_density"])
    known["damping_coefficient"] = contact_damping(
        known["damping_ratio"], mass, known["effective_youngs_modulus"], given["particle_radius"],
        damping_coefficient,
    )  # fmt: skip
    return {name: known.get(name, derived[name]) for name in FEATURE_NAMES if name not in given}

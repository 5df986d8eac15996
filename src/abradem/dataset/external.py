"""An external table, used instead of simulations.

The table is CSV or Parquet. A column is found by its name in this package, by its name in the
published table of the paper, or by the mapping in the configuration. Units are those of
`abradem.quantities` unless the mapping or the metadata of a Parquet field names another accepted
unit. Values outside the physical limits, the typical result of a wrong unit, are rejected.
Derived features that are missing are computed. Those in the table are used unchanged (the
published table rounds Young's modulus of the plate, for example) unless they contradict their
formula. A data set written by this package is also a valid table.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pandas as pd

from abradem.dataset.features import contact_damping, derive
from abradem.elastic import effective_youngs_modulus, sphere_mass
from abradem.quantities import (
    FEATURE_NAMES,
    QUANTITIES,
    SAMPLED_NAMES,
    TARGET,
    WEAR_COLUMNS,
    quantity,
)
from abradem.store.columns import COLUMNS
from abradem.store.files import TableError
from abradem.units import UNITS

PUBLISHED_NAMES = {
    "particle_youngs_modulus": "Young's Modulus (Material)",
    "particle_shear_modulus": "Shear Modulus (Material)",
    "particle_poisson_ratio": "Poisson's Ratio (Material)",
    "particle_density": "Density (Material)",
    "equipment_youngs_modulus": "Young's Modulus (Equipment)",
    "equipment_shear_modulus": "Shear Modulus (Equipment)",
    "equipment_poisson_ratio": "Poisson's Ratio (Equipment)",
    "equipment_density": "Density (Equipment)",
    "restitution": "Coefficient of Restitution (Interaction)",
    "rolling_friction": "Coefficient of Rolling Friction (Interaction)",
    "static_friction": "Coefficient of Static Friction (Interaction)",
    "archard_constant": "Archard Wear Constant",
    "plate_angle": "Plate Angle",
    "factory_angle": "Factory Angle",
    "particle_radius": "Particle Size",
    "particle_velocity_y": "Factory Z Velocity",
    "effective_youngs_modulus": "Equivalent Young's Modulus (E*)",
    "effective_shear_modulus": "Equivalent Shear Modulus (G*)",
    "damping_ratio": "Logarithmic Damping Ratio (ξ)",
    "damping_coefficient": "Damping Coefficient (η)",
    TARGET.name: "Wear Rate",
}
"""Columns of the published table of the paper. Its particle size is the radius, m."""

CLOSE = 0.05
"""Relative difference up to which a derived value agrees with its formula, as for two digits."""
LARGEST_KEY = 2**53
"""Largest case number: case numbers are read as floating-point numbers, exact up to here."""
MOST_LINES = 20
"""Largest number of bad rows that are reported individually."""

Mapped = Mapping[str, str | tuple[str, str]]


def read_external(
    path: str | Path, columns: Mapped | None = None, damping_coefficient: str = "table"
) -> pd.DataFrame:
    """Read a user's table as a data set.

    Parameters
    ----------
    path : path-like
        ``.csv`` (UTF-8, comma) or ``.parquet``.
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
    path = Path(path)
    table, units = _read(path)
    columns = dict(columns or {})
    wanted = (*FEATURE_NAMES, *WEAR_COLUMNS)
    problems = [
        f"{path}: mapping of {name}: no such quantity; known are {', '.join(wanted)}"
        for name in columns
        if name not in wanted
    ]
    found: dict[str, np.ndarray] = {}
    taken: dict[str, str] = {}
    faulty = set()
    for name in wanted:
        column, unit, problem = _source(name, columns.get(name), table, units)
        if column in taken:
            problem = f"column {column!r} is mapped to both {taken[column]} and {name}"
        if problem:
            problems.append(f"{path}: {problem}")
            faulty.add(name)
        elif column is not None:
            taken[column] = name
            values, bad = _numbers(table[column])
            problems += [f"{path}: {line}" for line in _bad_numbers(column, table[column], bad)]
            found[name] = values * UNITS[COLUMNS[name].unit][unit]
    problems += [
        f"{path}: lacks a column for {name} (looked for {name}, "
        f"{PUBLISHED_NAMES[name]}; map it with dataset.columns)"
        for name in SAMPLED_NAMES
        if name not in found and name not in faulty
    ]
    if not any(name in found or name in faulty for name in WEAR_COLUMNS):
        problems.append(
            f"{path}: lacks a wear rate (looked for {', '.join(WEAR_COLUMNS[:1])}, "
            f"{PUBLISHED_NAMES[TARGET.name]}; map it with dataset.columns)"
        )
    keys, problem = _keys(table)
    if problem:
        problems.append(f"{path}: {problem}")
    if not problems and not len(table):
        problems.append(f"{path}: holds no rows")
    if problems:
        raise TableError("\n".join(problems))
    problems = [f"{path}: {line}" for line in _bad_rows(found)]
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


def _read(path: Path) -> tuple[pd.DataFrame, dict[str, str]]:
    """Return the table as text or numbers, and the units in the metadata of its fields."""
    if path.suffix.lower() in (".parquet", ".pq"):
        from abradem.store.tables import read_table, read_units

        return read_table(path), {name: unit for name, unit in read_units(path).items() if unit}
    if path.suffix.lower() != ".csv":
        raise TableError(f"{path}: is neither .csv nor .parquet")
    try:
        # The header is read as a row. Otherwise a row with one extra field shifts all columns.
        table = pd.read_csv(
            path, dtype=str, encoding="utf-8-sig", keep_default_na=False, header=None
        )
    except FileNotFoundError:
        raise TableError(f"{path}: no such file") from None
    except (pd.errors.ParserError, pd.errors.EmptyDataError, UnicodeDecodeError, OSError) as error:
        raise TableError(f"{path}: not a CSV table ({str(error).splitlines()[0]})") from None
    header = [str(name).strip() for name in table.iloc[0]]
    wrong = next((mark for mark in ";\t|" if len(header) == 1 and mark in header[0]), None)
    if wrong:
        raise TableError(f"{path}: columns must be separated by commas, not by {wrong!r}")
    return table.iloc[1:].set_axis(header, axis=1).reset_index(drop=True), {}


def _keys(table: pd.DataFrame) -> tuple[np.ndarray, str]:
    """Return the case numbers of the rows, and the problem with them or ""."""
    if "case_id" not in table:
        return np.arange(len(table), dtype=np.int64), ""
    if list(table.columns).count("case_id") > 1:
        return np.empty(0), "column 'case_id' appears twice"
    values, bad = _numbers(table["case_id"])
    if bad.any() or (values != np.rint(values)).any() or len(set(values)) < len(values):
        return values, "column 'case_id': must contain whole numbers, each once"
    if (np.abs(values) > LARGEST_KEY).any():
        return values, f"column 'case_id': contains numbers beyond {LARGEST_KEY}"
    return values.astype(np.int64), ""


def _source(name: str, mapped, table: pd.DataFrame, units: dict[str, str]):
    """Return the column of the table for a name, its unit, and the problem with them or ""."""
    unit = None
    if mapped is not None:
        column, unit = (mapped, None) if isinstance(mapped, str) else mapped
        if column not in table:
            return None, None, f"lacks column {column!r}, which {name} is mapped to"
    else:
        candidates = dict.fromkeys((name, PUBLISHED_NAMES.get(name, name)))
        there = [one for one in candidates if one in table]
        if not there:
            return None, None, ""
        column = there[0]
        if len(there) > 1:
            both = " and ".join(map(repr, there))
            problem = f"columns {both} both contain {name}; choose one with dataset.columns"
            return None, None, problem
    if list(table.columns).count(column) > 1:
        return None, None, f"column {column!r} appears twice"
    ours = COLUMNS[name].unit
    unit = unit or units.get(column, ours)
    if unit not in UNITS[ours]:
        known = ", ".join(UNITS[ours])
        return None, None, f"column {column!r}: unit {unit!r} is unknown for {name} ({known})"
    return column, unit, ""


def _numbers(values: pd.Series) -> tuple[np.ndarray, np.ndarray]:
    """Return the column as numbers, and a mask of the rows without a finite number."""
    if values.dtype.kind in "bmMc":
        # Dates, durations and booleans would silently be converted to numbers.
        return np.full(len(values), np.nan), np.ones(len(values), dtype=bool)
    if values.dtype.kind == "O":
        values = values.where(~values.map(lambda value: isinstance(value, bool)), None)
    found = pd.to_numeric(values, errors="coerce").to_numpy(dtype=float)
    return found, ~np.isfinite(found)


def _bad_numbers(column: str, values: pd.Series, bad: np.ndarray) -> list[str]:
    rows = np.flatnonzero(bad)
    if len(rows) == len(values) > 0:
        return [f"column {column!r}: contains no numbers (first {values.iloc[0]!r})"]
    return _capped(
        [f"row {row + 1}: {column} = {values.iloc[row]!r} is not a finite number" for row in rows]
    )


def _bad_rows(found: dict[str, np.ndarray]) -> list[str]:
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
        if len(bad) > 1 and len(bad) == len(values):
            lines.append(
                f"column {name}: all {len(values)} values are out of limits (first "
                f"{values[0]:g}{unit}), {law}; give its unit with dataset.columns"
            )
        else:
            lines += [f"row {at + 1}: {name} = {values[at]:g}{unit} {law}" for at in bad]
    return _capped(lines)


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
    return _capped(lines)


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


def _capped(lines: list[str]) -> list[str]:
    if len(lines) <= MOST_LINES:
        return lines
    return [*lines[:MOST_LINES], f"and {len(lines) - MOST_LINES} more such lines"]

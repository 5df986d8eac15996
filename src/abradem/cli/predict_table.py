"""`abradem predict --table`: predictions for all cases of a user's table."""

from __future__ import annotations

import re
import sys
from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pandas as pd

from abradem.cli.given_values import Given, value_text
from abradem.cli.predict_words import depth_words, level_text, place_words, warn
from abradem.dataset.known_names import normal
from abradem.dataset.user_table import (
    UserTable,
    column_values,
    expanded,
    find_columns,
    plain_numbers,
    read_as,
    read_user_table,
    similar_columns,
    table_suffix,
    unused_columns,
)
from abradem.quantities import FEATURE_NAMES, quantity, wear_parts
from abradem.store.files import TableError, replacing, write_text
from abradem.surrogate.groups import Jet, input_names
from abradem.surrogate.model import Prediction, PredictionError, Surrogate
from abradem.words.labels import LABELS

FROM_DERIVED = {
    "particle_shear_modulus": (
        "particle_youngs_modulus", "effective_youngs_modulus", "effective_shear_modulus",
        "damping_coefficient",
    ),
    "equipment_shear_modulus": (
        "equipment_youngs_modulus", "effective_youngs_modulus", "effective_shear_modulus",
        "damping_coefficient",
    ),
    "particle_poisson_ratio": ("effective_youngs_modulus", "effective_shear_modulus"),
    "equipment_poisson_ratio": ("effective_youngs_modulus", "effective_shear_modulus"),
    "restitution": ("damping_ratio", "damping_coefficient"),
}  # fmt: skip
"""Derived quantities that would contradict a sampled one that is not in the same table."""


def predict_table(
    surrogate: Surrogate,
    given: Given,
    path: str,
    output: str | None,
    depth: float | None,
    level: float | None,
) -> None:
    """Predict the cases of a table and write or print it with three more columns for each rate.

    Parameters
    ----------
    surrogate : Surrogate
    given : Given
        Values for quantities that the table lacks.
    path, output : path-like
        ``output`` None prints the table as CSV.
    depth : float or None
        mm; adds the hours until this depth, three more columns for each rate.
    level : float or None
        Level of the interval.

    Raises
    ------
    TableError, PredictionError
        With one line for each problem.
    """
    target = None if output is None else _target(output, path)
    table = read_user_table(path)
    values = _values(table, given, surrogate.jet)
    try:
        found = surrogate.predict_all(values, level)
    except PredictionError as error:
        raise PredictionError(
            "\n".join(f"{path}: {line}" for line in str(error).splitlines())
        ) from None
    first = next(iter(found))
    warn(found[first].warnings)
    columns: dict[str, tuple] = {}
    for name, prediction in found.items():
        # Those of the target have plain names, the others that of their statistic as well.
        behind = "" if name == first else f"_{wear_parts(name)[1]}"
        columns |= _rate_columns(surrogate, name, prediction, behind)
        if depth is not None:
            columns |= _hour_columns(surrogate, name, prediction, depth, behind)
    _refuse_taken(table, columns)
    if target is None:
        print(_csv(table, columns), end="")
    elif table_suffix(target) == ".csv":
        write_text(_csv(table, columns), target)
    else:
        _write_parquet(table, columns, target)
    words, interval = place_words(surrogate), level_text(found[first].confidence, surrogate)
    words += f" and {len(found) - 1} others" if len(found) > 1 else ""
    count = len(table.frame)
    where = "" if target is None else f", written to {output}"
    print(
        f"{count} case{'' if count == 1 else 's'} predicted: {words}, {interval} interval{where}",
        file=sys.stderr if target is None else sys.stdout,
    )


def _rate_columns(surrogate: Surrogate, name: str, prediction: Prediction, behind: str) -> dict:
    """Return the columns of a wear rate: values, unit and meaning by their names."""
    unit, interval = (
        surrogate.models[name].target["unit"],
        level_text(prediction.confidence, surrogate, name),
    )
    words = place_words(surrogate, name)
    rate = f"wear_depth_rate{behind}"
    return {
        rate: (prediction.rate, unit, f"wear depth rate, {words}"),
        f"{rate}_lower": (prediction.lower, unit, f"lower end of the {interval} interval"),
        f"{rate}_upper": (prediction.upper, unit, f"upper end of the {interval} interval"),
    }


def _hour_columns(
    surrogate: Surrogate, name: str, prediction: Prediction, depth: float, behind: str
) -> dict:
    """Return the columns of the hours until a depth, mm."""
    middle, least, most = prediction.hours_to(depth)
    interval = level_text(prediction.confidence, surrogate, name)
    of = f"hours until {depth:g} mm ({depth_words(surrogate, name)})"
    return {
        f"hours{behind}": (middle, "h", of),
        f"hours{behind}_lower": (least, "h", f"{of}, lower end of the {interval} interval"),
        f"hours{behind}_upper": (most, "h", f"{of}, upper end of the {interval} interval"),
    }


def _target(output: str, path: str) -> Path:
    """Return where the output is written; refuse what is no place for a file of its own."""
    table_suffix(output)
    target = expanded(output)
    if target.is_symlink() or (target.exists() and not target.is_file()):
        raise PredictionError(f"--output {output}: is a link, a folder or a device; name a file")
    if target.exists() and target.samefile(expanded(path)):
        raise PredictionError(f"--output {output}: is the table itself; name another file")
    return target


def _values(table: UserTable, given: Given, jet: Jet) -> dict[str, np.ndarray]:
    """Return the sampled quantities, from the table and otherwise from the command line."""
    sampled = input_names(jet)
    places, faulty = find_columns(table, dict.fromkeys((*FEATURE_NAMES, *sampled)))
    problems = [line for name, line in faulty.items() if name in sampled]
    values, taken = {}, [place.column for place in places.values()]
    for name in sampled:
        if name in places:
            values[name], lines = column_values(table, name, places[name])
            problems += lines
            if given.origins.get(name) == "command line":
                column = places[name].column
                problems.append(
                    f"{name} is on the command line and in column {column!r}; give it once"
                )
    lacking = [name for name in sampled if name not in places and name not in faulty]
    if len(lacking) == len(sampled):
        problems.append(
            f"has no column with a known quantity (columns {', '.join(table.frame.columns)}; "
            f"known are {', '.join(sampled)})"
        )
    for name in lacking:
        similar = similar_columns(table, name, taken)
        if name not in given.values or len(lacking) == len(sampled):
            continue
        where = f"{name} would be taken from the {_origin(given, name)}"
        contrary = [one for one in FROM_DERIVED.get(name, ()) if one in places]
        if similar:
            problems.append(
                f"column {' or '.join(map(repr, similar))} is unknown; rename it to {name} if that "
                f"is meant ({_meaning(name)}), otherwise remove it, as {where}"
            )
        elif contrary:
            problems.append(
                f"column {places[contrary[0]].column!r} holds {contrary[0]}, but {where}; give "
                f"{name} in the table or remove the column"
            )
        else:
            values[name] = np.full(len(table.frame), given.values[name])
    missing = [name for name in lacking if name not in given.values]
    if missing:
        problems.append(f"missing: {', '.join(missing)}")
    if problems:
        raise TableError("\n".join(f"{table.path}: {line}" for line in problems))
    _say(table, {name: place for name, place in places.items() if name in sampled}, taken)
    filled = [
        f"{value_text(name, given.values[name])} ({_origin(given, name)})" for name in lacking
    ]
    if filled:
        print(f"{table.path}: not in the table: {', '.join(filled)}", file=sys.stderr)
    return values


def _say(table: UserTable, sampled: Mapping, taken: list[str]) -> None:
    """Say which columns were read as something else than their name, and which were not used."""
    if renamed := read_as(sampled):
        print(f"{table.path}: read {renamed}", file=sys.stderr)
    if "particle_radius" in sampled and "size" in normal(sampled["particle_radius"].column):
        print(f"{table.path}: the size is read as the radius", file=sys.stderr)
    if unused := unused_columns(table, taken):
        print(f"{table.path}: not used: {', '.join(map(repr, unused))}", file=sys.stderr)


def _meaning(name: str) -> str:
    unit = quantity(name).unit
    words = LABELS[name].long_name
    half = ", half of the diameter" if name == "particle_radius" else ""
    return f"{words}{half}{'' if unit == '1' else f', {unit}'}"


def _origin(given: Given, name: str) -> str:
    origin = given.origins[name]
    return origin if origin == "command line" else f"preset {origin}"


def _refuse_taken(table: UserTable, columns: dict) -> None:
    names = {*columns, *(_with_unit(name, unit) for name, (_, unit, _) in columns.items())}
    taken = [repr(name) for name in table.frame.columns if name in names]
    if taken:
        raise PredictionError(
            f"{table.path}: already has column {', '.join(taken)}; rename or remove it"
        )


def _with_unit(name: str, unit: str) -> str:
    return f"{name} [{unit}]"


def _csv(table: UserTable, columns: dict) -> str:
    """Return the table and the new columns as CSV, each new name with its unit in brackets."""
    frame = table.frame.rename(
        columns={name: _with_unit(name, unit) for name, unit in table.units.items() if unit != "1"}
    )
    added = {_with_unit(name, unit): values for name, (values, unit, _) in columns.items()}
    return pd.concat([frame, pd.DataFrame(added)], axis=1).to_csv(index=False)


def _write_parquet(table: UserTable, columns: dict, path: Path) -> None:
    """Write the table and the new columns, each with its unit in the metadata of its field."""
    import pyarrow as pa
    import pyarrow.parquet as pq

    arrays, fields = [], []
    for name in table.frame.columns:
        try:
            array = pa.array(_as_numbers(table, name), from_pandas=True)
        except pa.ArrowException as error:
            reason = str(error).splitlines()[0]
            raise TableError(
                f"{table.path}: column {name!r} cannot be written as Parquet ({reason}); remove "
                "it or write .csv"
            ) from None
        unit = table.units.get(name)
        arrays.append(array)
        fields.append(pa.field(name, array.type, metadata={"units": unit} if unit else None))
    for name, (values, unit, words) in columns.items():
        arrays.append(pa.array(values))
        metadata = {"units": unit, "long_name": words}
        fields.append(pa.field(name, pa.float64(), metadata=metadata))
    with replacing(path) as sink:
        pq.write_table(pa.table(arrays, schema=pa.schema(fields)), sink, write_page_checksum=True)


def _as_numbers(table: UserTable, name: str) -> pd.Series:
    """Return a column of a CSV table as numbers if all its cells are; others as they are."""
    cells = table.frame[name]
    if not table.separator:
        return cells
    numbers, bad = plain_numbers(cells)
    # "007" is no number but a name.
    names = any(re.match(r"\s*[-+]?0[0-9]", cell) for cell in cells)
    return cells if bad.any() or names else pd.Series(numbers)

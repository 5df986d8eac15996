"""`abradem predict --table`: predictions for all cases of a user's table."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pandas as pd

from abradem.cli.given_values import Given, value_text
from abradem.cli.predict import depth_words, level_text, warn
from abradem.dataset.user_table import (
    UserTable,
    column_values,
    find_columns,
    read_user_table,
    similar_columns,
    table_suffix,
)
from abradem.quantities import FEATURE_NAMES, SAMPLED_NAMES
from abradem.store.files import TableError, replacing, write_text
from abradem.surrogate.model import PredictionError, Surrogate
from abradem.words.labels import wear_words


def predict_table(
    surrogate: Surrogate,
    given: Given,
    path: str,
    output: str | None,
    depth: float | None,
    level: float | None,
) -> None:
    """Predict the cases of a table and write or print it with three (or six) more columns.

    Parameters
    ----------
    surrogate : Surrogate
    given : Given
        Values for quantities that the table lacks.
    path, output : path-like
        ``output`` None prints the table as CSV.
    depth : float or None
        mm; adds the hours until this depth.
    level : float or None
        Level of the interval.

    Raises
    ------
    TableError, PredictionError
        With one line for each problem.
    """
    target = None if output is None else _target(output, path)
    table = read_user_table(path)
    values = _values(table, given)
    try:
        prediction = surrogate.predict(values, level)
    except PredictionError as error:
        raise PredictionError(
            "\n".join(f"{path}: {line}" for line in str(error).splitlines())
        ) from None
    warn(prediction.warnings)
    description = surrogate.description["target"]
    words = wear_words(description["name"])
    interval = level_text(prediction, surrogate)
    columns = {
        "wear_depth_rate": (prediction.rate, description["unit"], f"wear depth rate, {words}"),
        "wear_depth_rate_lower": (
            prediction.lower, description["unit"], f"lower end of the {interval} interval",
        ),
        "wear_depth_rate_upper": (
            prediction.upper, description["unit"], f"upper end of the {interval} interval",
        ),
    }  # fmt: skip
    if depth is not None:
        middle, least, most = prediction.hours_to(depth)
        of = f"hours until {depth:g} mm ({depth_words(surrogate)})"
        columns |= {
            "hours": (middle, "h", of),
            "hours_lower": (least, "h", f"{of}, lower end of the {interval} interval"),
            "hours_upper": (most, "h", f"{of}, upper end of the {interval} interval"),
        }
    _refuse_taken(table, columns)
    if target is None:
        print(_csv(table, columns), end="")
    elif table_suffix(target) == ".csv":
        write_text(_csv(table, columns), target)
    else:
        _write_parquet(table, columns, target)
    count = len(table.frame)
    where = "" if target is None else f", written to {output}"
    print(
        f"{count} case{'' if count == 1 else 's'} predicted: {words}, {interval} interval{where}",
        file=sys.stderr if target is None else sys.stdout,
    )


def _target(output: str, path: str) -> Path:
    table_suffix(output)
    target = Path(output).expanduser()
    if (
        target.exists()
        and Path(path).expanduser().exists()
        and target.samefile(Path(path).expanduser())
    ):
        raise PredictionError(f"--output {output}: is the table itself; name another file")
    return target


def _values(table: UserTable, given: Given) -> dict[str, np.ndarray]:
    """Return the sampled quantities, from the table and otherwise from the command line."""
    places, faulty = find_columns(table, FEATURE_NAMES)
    problems = [line for name, line in faulty.items() if name in SAMPLED_NAMES]
    values, taken = {}, [place.column for place in places.values()]
    for name in SAMPLED_NAMES:
        if name in places:
            values[name], lines = column_values(table, name, places[name])
            problems += lines
            if given.origins.get(name) == "command line":
                column = places[name].column
                problems.append(
                    f"{name} is on the command line and in column {column!r}; give it once"
                )
    lacking = [name for name in SAMPLED_NAMES if name not in places and name not in faulty]
    if len(lacking) == len(SAMPLED_NAMES):
        problems.append(
            f"has no column with a known quantity (columns {', '.join(table.frame.columns)}; "
            f"known are {', '.join(SAMPLED_NAMES)})"
        )
    for name in lacking:
        similar = similar_columns(table, name, taken)
        if similar and name in given.values and len(lacking) < len(SAMPLED_NAMES):
            problems.append(
                f"column {' or '.join(map(repr, similar))} is unknown; rename it to {name} if that "
                f"is meant, otherwise remove it, as {name} would be taken from the "
                f"{_origin(given, name)}"
            )
        elif name in given.values:
            values[name] = np.full(len(table.frame), given.values[name])
    missing = [name for name in lacking if name not in given.values]
    if missing:
        problems.append(f"missing: {', '.join(missing)}")
    if problems:
        raise TableError("\n".join(f"{table.path}: {line}" for line in problems))
    filled = [
        f"{value_text(name, given.values[name])} ({_origin(given, name)})" for name in lacking
    ]
    if filled:
        print(f"{table.path}: not in the table: {', '.join(filled)}", file=sys.stderr)
    return values


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

    added = pd.DataFrame({name: values for name, (values, _, _) in columns.items()})
    arrow = pa.Table.from_pandas(
        pd.concat([table.frame, added], axis=1), preserve_index=False
    ).replace_schema_metadata(None)
    fields = []
    for field in arrow.schema:
        if field.name in columns:
            _, unit, words = columns[field.name]
            field = field.with_metadata({"units": unit, "long_name": words})
        elif field.name in table.units:
            field = field.with_metadata({"units": table.units[field.name]})
        fields.append(field)
    with replacing(path) as sink:
        pq.write_table(arrow.cast(pa.schema(fields)), sink, write_page_checksum=True)

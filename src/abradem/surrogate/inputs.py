"""The quantities for which a surrogate is asked: whether they are complete and possible."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from abradem.quantities import impossible, quantity
from abradem.surrogate.groups import Jet, input_names, squared_impact_speed


class PredictionError(ValueError):
    """The model cannot be read, or the values are invalid; the message has one line per problem."""


def checked_columns(values: Mapping, jet: Jet) -> dict[str, np.ndarray]:
    """The quantities of `input_names`, checked, as arrays of the same length."""
    names = input_names(jet)
    missing = [name for name in names if name not in values]
    if missing:
        raise PredictionError(f"missing: {', '.join(missing)}")
    columns = {}
    problems = []
    for row in map(quantity, names):
        try:
            column = np.atleast_1d(np.asarray(values[row.name], dtype=float))
        except (TypeError, ValueError):
            problems.append(f"{row.name} = {values[row.name]!r} is not a number")
            continue
        low, high = row.limits
        wrong = ~((column >= low) & (column <= high))
        if wrong.any():
            place = int(np.argmax(wrong))
            where = "" if len(column) == 1 else f" in row {place + 1}"
            problems.append(str(impossible(row.name, float(column[place]), where)))
        columns[row.name] = column
    if problems:
        raise PredictionError("\n".join(problems))
    try:
        columns = dict(zip(columns, np.broadcast_arrays(*columns.values()), strict=True))
    except ValueError:
        lengths = {name: len(column) for name, column in columns.items() if len(column) > 1}
        raise PredictionError(f"columns of different length: {lengths}") from None
    if not np.all(squared_impact_speed(columns, jet) > 0.0):
        raise PredictionError("particles without initial velocity that do not fall cause no wear")
    return columns

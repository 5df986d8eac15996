"""The one reader of users' tables, for `abradem.dataset.external` and `abradem predict --table`.

CSV and Parquet files give the same columns and the same refusals. A column is found by its name in
this package, its symbol, its key in the configuration, its name in the published table of the
paper, or a mapping, whatever case and separators between words; ``name [unit]`` and
``name (unit)`` name a unit as well. A cell may carry a unit of its own, such as "20 mm". Rows are
counted from 1, without the header and without blank lines.
"""

from __future__ import annotations

import csv
import io
import re
import stat
from collections import Counter
from collections.abc import Iterable, Mapping
from decimal import Decimal
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pandas as pd

from abradem.dataset.known_names import PUBLISHED_NAMES, may_mean, names_of, normal, visible
from abradem.quantities import TARGET, quantity
from abradem.store.columns import COLUMNS
from abradem.store.files import TableError
from abradem.units import UnitError, conversion, convert, parse_quantity, parse_unit

MOST_LINES = 20
"""Largest number of bad rows that are reported individually."""

SEPARATORS = {",": "a comma", ";": "a semicolon", "\t": "a tab", "|": "a bar"}

_NAME_AND_UNIT = re.compile(
    r"(.*\S)\s*(?:\[([^\[\]]*)\]|\(([^()]*(?:\([^()]*\))?[^()]*)\))", re.DOTALL
)
_PLAIN_NUMBER = re.compile(r"[+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]{1,3})?")
_NAME_THEN_UNIT = re.compile(r"(.*\S)(?:\s*/\s*|\s*,\s*|\s+in\s+)(\S.*)", re.DOTALL)
_DECIMAL_COMMA = re.compile(r"\s*[-+−]?[0-9]*,[0-9]+(?:[eE][-+−]?[0-9]+)?(?![0-9,.])")
_DECIMAL_POINT = re.compile(r"\s*[-+−]?[0-9]*\.[0-9]+")
_THOUSANDS = re.compile(r"\s*[-+−]?[1-9][0-9]{0,2},[0-9]{3}(?![0-9,.])")
_ADDRESS = re.compile(r"[A-Za-z][A-Za-z0-9+.-]*://")


class UserTable(NamedTuple):
    """A table as it is in its file.

    Attributes
    ----------
    path : Path
    frame : pandas.DataFrame
        Columns with stripped names, each once; text (CSV) or the types of the Parquet file.
    units : dict of str to str
        Units in the metadata of Parquet fields.
    separator : str
        Of a CSV table, otherwise "". Only where it is no comma, a number may have a decimal comma.
    """

    path: Path
    frame: pd.DataFrame
    units: dict[str, str]
    separator: str = ""


class Found(NamedTuple):
    """A quantity of a table: its column, and the unit of the column in the table, or None."""

    column: str
    unit: str | None


def expanded(path: str | Path) -> Path:
    """Return a path with ``~`` expanded.

    Raises
    ------
    TableError
        If it is an address, has control characters, or names a user that does not exist.
    """
    text = str(path)
    # Path("http://x") has a single slash.
    if _ADDRESS.match(text) or re.match(r"(?:https?|ftp|s3|file):/", text):
        raise TableError(f"{text}: is an address, not a file on this machine")
    if any(ord(mark) < 32 or ord(mark) == 127 for mark in text):
        raise TableError(f"{text!r}: the path contains a control character")
    try:
        return Path(text).expanduser()
    except RuntimeError as error:  # no such user
        raise TableError(f"{text}: {error}") from None


def local_file(path: str | Path) -> Path:
    """Return the path of a regular file, with ``~`` expanded.

    Raises
    ------
    TableError
        If it is an address, or there is no regular file.
    """
    text = str(path)
    found = expanded(text)
    try:
        mode = found.stat().st_mode
    except FileNotFoundError:
        raise TableError(f"{text}: there is no such file") from None
    except OSError as error:
        raise TableError(f"{text}: cannot be read ({error.strerror})") from None
    if not stat.S_ISREG(mode):
        kind = "a folder" if stat.S_ISDIR(mode) else "a pipe or a device"
        raise TableError(f"{text}: is {kind}, not a file")
    return found


def table_suffix(path: str | Path) -> str:
    """Return ".csv" or ".parquet" for the name of a table, whatever its case."""
    suffix = Path(path).suffix.lower()
    if suffix in (".parquet", ".pq"):
        return ".parquet"
    if suffix != ".csv":
        raise TableError(f"{path}: is neither .csv nor .parquet")
    return suffix


def read_user_table(path: str | Path) -> UserTable:
    """Read a table as it is in its file.

    Parameters
    ----------
    path : path-like
        ``.csv`` (UTF-8; separated by commas, semicolons, tabs or bars; a decimal comma where the
        separator is another) or ``.parquet``.

    Raises
    ------
    TableError
        If the file is no table, with one line.
    """
    suffix = table_suffix(path)
    file = local_file(path)
    separator = ""
    if suffix == ".parquet":
        from abradem.store.tables import range_index, read_table, read_units

        frame = read_table(file)
        units = {visible(name): unit for name, unit in read_units(file).items() if unit}
        if lost := range_index(file):
            raise TableError(
                f"{path}: its index {lost!r} is in the metadata for pandas alone; write it as a "
                "column (reset_index)"
            )
    else:
        frame, separator = _read_csv(file)
        units = {}
    # Names as text, because a Parquet file can be of any origin.
    frame.columns = pd.Index([visible(str(name)) for name in frame.columns], dtype=object)
    twice = [repr(name) for name, count in Counter(frame.columns).items() if count > 1]
    if twice:
        raise TableError(f"{path}: column {', '.join(twice)} appears twice")
    if not len(frame):
        raise TableError(f"{path}: holds no rows")
    return UserTable(Path(path), frame.reset_index(drop=True), units, separator)


def _read_csv(path: Path) -> tuple[pd.DataFrame, str]:
    """Return the table as text, every row as wide as the header, and its separator."""
    content = path.read_bytes()
    if content.startswith((b"\xff\xfe", b"\xfe\xff")):
        raise TableError(f"{path}: is UTF-16 text; save it as UTF-8")
    if content.startswith((b"\x1f\x8b", b"PK\x03\x04")):
        raise TableError(f"{path}: is a packed file or a workbook; save the table as CSV")
    if b"\0" in content:
        raise TableError(f"{path}: not a CSV table (it contains a zero byte); save it as UTF-8")
    try:
        text = content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        # Places are counted behind a byte order mark.
        line = error.object.count(b"\n", 0, error.start) + 1
        raise TableError(
            f"{path}: line {line} is not UTF-8 text (byte 0x{error.object[error.start]:02x}); "
            "save it as UTF-8"
        ) from None
    # The first line by which Excel says how columns are separated.
    said = re.match(r"sep=(.)\r?\n", text)
    if said:
        text = text[said.end() :]
    separator, header, rows = _rows(path, text, said.group(1) if said else SEPARATORS)
    for number, row in enumerate(rows, start=1):
        if len(row) != len(header):
            raise TableError(
                f"{path}: row {number} has {len(row)} cells, the header has {len(header)} "
                f"(separated by {SEPARATORS[separator]})"
            )
    columns = [list(cells) for cells in zip(*rows, strict=True)] or [[] for _ in header]
    # Columns without a name and without a value, from separators at the end of the lines.
    kept = [
        place
        for place, name in enumerate(header)
        if visible(name) or any(cell.strip() for cell in columns[place])
    ]
    frame = pd.DataFrame({place: columns[place] for place in kept}, dtype=object)
    return frame.set_axis([header[place] for place in kept], axis=1), separator


def _rows(
    path: Path, text: str, separators: Iterable[str]
) -> tuple[str, list[str], list[list[str]]]:
    """Return the separator, the names and the rows of a text, without blank lines.

    The separator is the one with which all rows have as many cells as the header. If there is
    none, it is the one that gives the most names, and a row is refused later.
    """
    tried = []
    for separator in separators:
        if separator not in SEPARATORS:
            raise TableError(f"{path}: separator {separator!r} is unknown (allowed , ; tab |)")
        lines = csv.reader(
            io.StringIO(text, newline=""), delimiter=separator, strict=True, skipinitialspace=True
        )
        try:
            rows = [row for row in lines if any(cell.strip() for cell in row)]
        except csv.Error as error:
            problem = error
            continue
        if not rows:
            raise TableError(f"{path}: not a CSV table (it is empty)")
        tried.append((separator, rows[0], rows[1:]))
    if not tried:
        raise TableError(f"{path}: not a CSV table ({problem})")
    many = [one for one in tried if len(one[1]) > 1]
    even = [one for one in many if all(len(row) == len(one[1]) for row in one[2])]
    if len(even) > 1:
        both = " or ".join(SEPARATORS[one[0]] for one in even)
        raise TableError(f"{path}: the columns may be separated by {both}; use commas")
    return (even or sorted(many, key=lambda one: -len(one[1])) or tried)[0]


def find_columns(
    table: UserTable,
    wanted: Iterable[str],
    mapped: Mapping[str, str | tuple[str, str] | list[str]] | None = None,
) -> tuple[dict[str, Found], dict[str, str]]:
    """Find the columns of quantities in a table.

    Parameters
    ----------
    table : UserTable
    wanted : iterable of str
        Names of quantities and wear columns.
    mapped : mapping, optional
        Column of the table, or a pair of column and unit, for some of them.

    Returns
    -------
    found : dict of str to Found
    problems : dict of str to str
        One line for each quantity whose column is not clear, without the name of the file.
    """
    mapped = dict(mapped or {})
    places: dict[str, list[Found]] = {}
    for column in table.frame.columns:
        for key, unit in _readings(column):
            places.setdefault(key, []).append(Found(column, unit))
    found: dict[str, Found] = {}
    problems: dict[str, str] = {}
    taken: dict[str, str] = {}
    for name in wanted:
        if name in mapped:
            given = mapped[name]
            column, unit = (given, None) if isinstance(given, str) else given
            column = str(column).strip()
            if column not in table.frame:
                problems[name] = f"lacks column {column!r}, which {name} is mapped to"
                continue
            here = [Found(column, unit)]
        else:
            here = _candidates(name, places)
        if not here:
            continue
        if len(here) > 1:
            both = " and ".join(repr(one.column) for one in here)
            problems[name] = (
                f"columns {both} both contain {name}; keep one, or choose with dataset.columns"
            )
            continue
        (one,) = here
        if one.column in taken:
            problems[name] = (
                f"column {one.column!r} is mapped to both {taken[one.column]} and {name}"
            )
            continue
        taken[one.column] = name
        unit, problem = _unit(table, name, one)
        if problem:
            problems[name] = f"column {one.column!r}, for {name}: {problem}"
            continue
        found[name] = Found(one.column, unit)
    unclear = _mixed_marks(table, found)
    return {name: one for name, one in found.items() if name not in unclear}, problems | unclear


def _mixed_marks(table: UserTable, found: Mapping[str, Found]) -> dict[str, str]:
    """Return a line for each quantity whose decimal mark is not clear, in a table without commas
    between its columns."""
    if table.separator in ("", ","):
        return {}
    with_comma, with_point, problems = [], [], {}
    for name, one in found.items():
        cells = [cell for cell in table.frame[one.column] if isinstance(cell, str)]
        commas = [cell for cell in cells if _DECIMAL_COMMA.match(cell)]
        if commas and all(_THOUSANDS.match(cell) for cell in commas):
            first = commas[0].strip()
            problems[name] = (
                f"column {one.column!r}: {first!r} may have a decimal comma or a separator of "
                f"thousands; write {first.replace(',', '.')} or {first.replace(',', '')}"
            )
        if commas:
            with_comma.append(name)
        if any(_DECIMAL_POINT.match(cell) for cell in cells):
            with_point.append(name)
    if with_comma:
        for name in with_point:
            problems[name] = (
                f"column {found[name].column!r} mixes decimal commas with points or separators of "
                f"thousands (column {found[with_comma[0]].column!r} has decimal commas)"
            )
    return problems


def _unit(table: UserTable, name: str, found: Found) -> tuple[str | None, str]:
    """Return the unit of a column, or None for that of the quantity, and the problem or ""."""
    ours = COLUMNS[name].unit
    said = (found.unit, _unit_in(found.column), table.units.get(found.column))
    given = list(dict.fromkeys(unit for unit in said if unit is not None))
    try:
        factors = {conversion(unit, ours) for unit in given}
    except UnitError as error:
        return None, str(error)
    if len(factors) > 1:
        return None, f"the units {' and '.join(map(repr, given))} of {name} contradict each other"
    return (given[0] if given else None), ""


def _readings(column: str) -> list[tuple[str, str | None]]:
    """Return the ways to read a column's name: normal name, and unit or None."""
    readings: list[tuple[str, str | None]] = [(normal(column), None)]
    split = _NAME_AND_UNIT.fullmatch(column)
    if split:
        name, square, round_ = split.groups()
        if square is not None or _is_unit(round_):
            readings.append((normal(name), (round_ if square is None else square).strip() or "1"))
    split = _NAME_THEN_UNIT.fullmatch(column)
    if split and _is_unit(split.group(2)):
        readings.append((normal(split.group(1)), split.group(2).strip()))
    return readings


def _is_unit(text: str) -> bool:
    try:
        parse_unit(text)
    except UnitError:
        return False
    return True


def _unit_in(column: str) -> str | None:
    """Return the unit in brackets at the end of a column's name, or None."""
    units = [unit for _, unit in _readings(column) if unit is not None and _is_unit(unit)]
    return units[0] if units else None


def _candidates(name: str, places: Mapping[str, list[Found]]) -> list[Found]:
    """Return the columns that may hold a quantity, each once."""
    here: dict[str, Found] = {}
    for key, own_unit in names_of(name).items():
        for one in places.get(key, ()):
            here.setdefault(one.column, Found(one.column, one.unit or own_unit))
    if name in PUBLISHED_NAMES and name != TARGET.name:
        symbol = quantity(name).symbol
        for one in places.get(normal(symbol), ()):
            # As it is written: x4 may be a coordinate.
            if one.column.startswith(symbol):
                here.setdefault(one.column, one)
    return list(here.values())


def similar_columns(table: UserTable, name: str, taken: Iterable[str]) -> list[str]:
    """Return the columns, other than those ``taken``, that may be meant for a quantity."""
    taken = set(taken)
    return [
        column
        for column in table.frame.columns
        if column not in taken and any(may_mean(key, name) for key, _ in _readings(column))
    ]


def read_as(places: Mapping[str, Found]) -> str:
    """Return which columns were read as which quantity, where the name is not that of it."""
    return ", ".join(
        f"{one.column!r} as {name}"
        for name, one in places.items()
        if normal(one.column) not in (normal(name), "")
    )


def unused_columns(table: UserTable, taken: Iterable[str]) -> list[str]:
    """Return the columns that hold numbers or name a unit, but were not read as a quantity."""
    taken = set(taken)
    return [
        column
        for column in table.frame.columns
        if column
        and column not in taken
        and column != "case_id"
        and (
            column in table.units
            or _unit_in(column) is not None
            or not plain_numbers(table.frame[column])[1].any()
        )
    ]


def column_values(table: UserTable, name: str, found: Found) -> tuple[np.ndarray, list[str]]:
    """Return the values of a quantity in its own unit, and one line for each that is none.

    Returns
    -------
    values : ndarray, shape (n,)
        NaN where the cell is not a finite number.
    problems : list of str
        One line each, without the name of the file.
    """
    ours = COLUMNS[name].unit
    cells = table.frame[found.column]
    if table.separator not in ("", ","):
        cells = cells.map(
            lambda cell: cell.replace(",", ".", 1) if _DECIMAL_COMMA.match(cell) else cell
        )
    values, bad = plain_numbers(cells)
    reasons: dict[int, str] = {}
    if found.unit is not None:
        values = convert(values, found.unit, ours)
    for row in np.flatnonzero(bad):
        cell = cells.iloc[row]
        if not isinstance(cell, str):
            reasons[int(row)] = _no_number(cell)
            continue
        if not cell.strip():
            reasons[int(row)] = "is empty"
            continue
        try:
            values[row] = parse_quantity(cell, ours, found.unit or ours)
            bad[row] = False
        except ValueError as error:
            reasons[int(row)] = str(error)
    rows = np.flatnonzero(bad)
    if 1 < len(rows) == len(cells):
        reason = reasons.get(0, "is not a finite number")
        first = f"first {cells.iloc[0]!r} {reason}"
        return values, [f"column {found.column!r}: contains no numbers ({first})"]
    lines = [
        f"row {row + 1}: {found.column} {_shown(cells.iloc[row])}"
        f"{reasons.get(int(row), 'is not a finite number')}"
        for row in rows
    ]
    return values, capped(lines)


def _shown(cell) -> str:
    """Return "= value " of a cell, or "" if it is empty."""
    if cell is None or (isinstance(cell, float) and np.isnan(cell)) or cell == "":
        return ""
    text = repr(cell.item() if isinstance(cell, np.generic) else cell)
    return f"= {text if len(text) <= 60 else text[:56] + ' ...'} "


def _no_number(cell) -> str:
    """Return why a cell that is no text is no finite number."""
    if cell is None or (isinstance(cell, (float, np.floating)) and np.isnan(cell)):
        return "is empty"
    if isinstance(cell, (list, dict, np.ndarray)):
        return "is a list, not a number"
    return "is not a finite number"


def plain_numbers(cells: pd.Series) -> tuple[np.ndarray, np.ndarray]:
    """Return a column as numbers, and a mask of the rows without a finite number.

    Booleans, dates and durations are no numbers.
    """
    if cells.dtype.kind in "iuf":
        values = cells.to_numpy(dtype=float, na_value=np.nan)
        return values, ~np.isfinite(values)
    values = np.array([_number(cell) for cell in cells], dtype=float)
    return values, ~np.isfinite(values)


def _number(cell) -> float:
    if isinstance(cell, str):
        text = cell.strip()
        return float(text) if _PLAIN_NUMBER.fullmatch(text) else np.nan
    if isinstance(cell, (bool, np.bool_)):
        return np.nan
    if isinstance(cell, (int, float, np.integer, np.floating, Decimal)):
        try:
            return float(cell)
        except OverflowError:
            return np.nan
    return np.nan


def repeated_rows(columns: Mapping[str, np.ndarray]) -> str:
    """Return one line on rows whose sampled quantities are all the same, or "" if there are none.

    Such rows, replicates for example, are no independent evidence: a model that learned from one
    has seen the others.
    """
    frame = pd.DataFrame(dict(columns))
    groups = [
        [int(row) + 1 for row in rows]
        for rows in frame.groupby(list(frame), sort=False, dropna=False).indices.values()
        if len(rows) > 1
    ]
    if not groups:
        return ""
    groups.sort()
    count = sum(map(len, groups))
    shown = ", ".join(
        "+".join(map(str, rows[:6])) + ("+..." if len(rows) > 6 else "") for rows in groups[:5]
    )
    more = f" and {len(groups) - 5} more groups" if len(groups) > 5 else ""
    return (
        f"{count} rows repeat the quantities of another, in {len(groups)} "
        f"group{'' if len(groups) == 1 else 's'} "
        f"(rows {shown}{more})"
    )


def capped(lines: list[str]) -> list[str]:
    """Return at most `MOST_LINES` lines and the number of the others."""
    if len(lines) <= MOST_LINES:
        return lines
    return [*lines[:MOST_LINES], f"and {len(lines) - MOST_LINES} more such lines"]

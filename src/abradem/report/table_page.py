"""A table as a page of HTML that sorts and filters its rows, complete in one file.

The page needs no network and no library: the tables of a study have tens to thousands of rows, for
which forty lines of script suffice. Libraries for this either load their code from elsewhere or add
about a megabyte for each table.
"""

from __future__ import annotations

import base64
from collections.abc import Sequence

import numpy as np
import pandas as pd

from abradem.learning.number_text import LARGEST, is_number
from abradem.store.tables import StoredColumn
from abradem.words.escaping import for_html

MOST_ROWS = 2000
"""Rows of a page; a browser sorts as many in the time of a keystroke."""


def table_page(
    name: str, table: pd.DataFrame, columns: Sequence[StoredColumn], template: str
) -> str:
    """A page with a table, for the report.

    Parameters
    ----------
    name : str
        Name of the table, the title of the page.
    table : pandas.DataFrame
        The rows in the order of the file.
    columns : sequence of StoredColumn
        Units and long names of its columns, from `abradem.store.tables.read_columns`.
    template : str
        The page without the table, workflow/report/table.html.

    Returns
    -------
    str
        HTML. Numbers are shown with six digits; cells hold their full value, which sorts the rows.
        Of a table with more than `MOST_ROWS` rows the first ones are shown, and the page says so. A
        link saves all rows as CSV.
    """
    told = {column.name: column for column in columns}
    numeric = {one: table[one].dtype.kind in "fiu" for one in table.columns}
    head = "".join(_header(told[one], numeric[one]) for one in table.columns)
    shown = table.head(MOST_ROWS)
    cells = [_cells(shown[one], numeric[one]) for one in table.columns]
    body = "\n".join(f"<tr>{''.join(row)}</tr>" for row in zip(*cells, strict=True))
    count = f"{len(table)} rows" if len(table) != 1 else "1 row"
    if len(table) > len(shown):
        count = f"the first {len(shown)} of {len(table)} rows"
    saved = base64.b64encode(table.to_csv(index=False).encode()).decode()
    parts = {
        "NAME": for_html(name),
        "COUNT": count,
        "HEAD": head,
        "BODY": body,
        "CSV": f"data:text/csv;base64,{saved}",
    }
    for key, text in parts.items():
        template = template.replace(f"<!--{key}-->", text)
    return template


def _header(column: StoredColumn, numeric: bool) -> str:
    unit = f" <small>{for_html(column.unit)}</small>" if column.unit not in ("", "1") else ""
    kind = ' class="number"' if numeric else ""
    words = for_html(column.long_name or column.name)
    return (
        f'<th scope="col"{kind} title="{words}"><button type="button">'
        f"{for_html(column.name).replace('_', '_<wbr>')}{unit}</button></th>"
    )


def _cells(values: pd.Series, numeric: bool) -> list[str]:
    if not numeric:
        return [f"<td>{for_html(_word(value))}</td>" for value in values]
    return [_number_cell(value) for value in values.tolist()]


def _word(value) -> str:
    if isinstance(value, (bool, np.bool_)):
        return "yes" if value else "no"
    return str(value).replace("_", " ")


def _number_cell(value: float) -> str:
    """A cell, empty for what is no number or without bound, as in `abradem.report.readable`."""
    if isinstance(value, int):
        shown = str(value)
    elif is_number(value) and abs(value) <= LARGEST:
        shown = f"{value:.6g}"
    else:
        return '<td class="number"></td>'
    return f'<td class="number" data-value="{value!r}">{shown}</td>'

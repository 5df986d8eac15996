"""The page of a table holds every number in full, and sorts its rows in a browser."""

import base64
import io
import re
import subprocess
from html.parser import HTMLParser
from pathlib import Path
from shutil import which

import numpy as np
import pandas as pd
import pytest

from abradem.report import table_page as page
from abradem.store.tables import StoredColumn

TEMPLATE = Path(__file__).parents[2] / "workflow" / "report" / "table.html"
COLUMNS = [
    StoredColumn("model", "string", "1", "model"),
    StoredColumn("rate", "double", "mm/s", "wear depth rate"),
    StoredColumn("rows", "int64", "1", "rows <of> the table"),
    StoredColumn("kept", "bool", "1", "whether it was kept"),
]
TABLE = pd.DataFrame(
    {
        "model": ["ga_ann", "a < b & c", "tree"],
        "rate": [0.1 + 0.2, np.nan, -1e-300],
        "rows": [2**53, 10, 9],
        "kept": [True, False, True],
    }
)


class Cells(HTMLParser):
    """Texts and full values of the cells of a table, by row."""

    def __init__(self):
        super().__init__()
        self.rows, self.heads, self.inside = [], [], None

    def handle_starttag(self, tag, attributes):
        values = dict(attributes)
        if tag == "tr":
            self.rows.append([])
        if tag == "td":
            self.rows[-1].append(["", values.get("data-value")])
        if tag == "th":
            self.heads.append(["", values["title"]])
        if tag in ("td", "th"):
            self.inside = tag

    def handle_endtag(self, tag):
        if tag in ("td", "th"):
            self.inside = None

    def handle_data(self, data):
        if self.inside:
            (self.rows[-1] if self.inside == "td" else self.heads)[-1][0] += data


def parsed(table=TABLE):
    text = page.table_page("a_table", table, COLUMNS, TEMPLATE.read_text(encoding="utf-8"))
    cells = Cells()
    cells.feed(text)
    return text, cells


def test_cells_hold_every_value_in_full_and_nothing_for_what_is_no_number():
    text, cells = parsed()
    first, second, third = cells.rows[1:]
    assert [cell[0] for cell in first] == ["ga ann", "0.3", str(2**53), "yes"]
    assert float(first[1][1]) == 0.1 + 0.2 and int(first[2][1]) == 2**53
    assert [cell[0] for cell in second] == ["a < b & c", "", "10", "no"] and second[1][1] is None
    assert float(third[1][1]) == -1e-300
    assert cells.heads == [
        ["model", "model"], ["rate mm/s", "wear depth rate"], ["rows", "rows <of> the table"],
        ["kept", "whether it was kept"],
    ]  # fmt: skip
    assert "<!--" not in text and "3 rows" in text


def test_the_page_saves_the_table_and_loads_nothing():
    text, _ = parsed()
    encoded = re.search(r'href="data:text/csv;base64,([^"]+)"', text).group(1)
    pd.testing.assert_frame_equal(pd.read_csv(io.BytesIO(base64.b64decode(encoded))), TABLE)
    assert not re.search(r"https?:", text)


def test_a_long_table_says_how_much_of_it_is_shown(monkeypatch):
    monkeypatch.setattr(page, "MOST_ROWS", 2)
    text, cells = parsed()
    assert "the first 2 of 3 rows" in text and len(cells.rows) == 3


@pytest.mark.skipif(which("chromium") is None, reason="no chromium on this machine")
def test_a_click_on_a_header_sorts_by_the_full_value(tmp_path):
    text, _ = parsed()
    clicks = (
        "const click = n => heads[n].firstElementChild.click();"
        "const order = n => inFile.map((_, i) => body.rows[i].cells[n].textContent).join('|');"
        "const seen = [];"
        "click(1); seen.push(order(1)); click(1); seen.push(order(1));"
        "click(2); seen.push(order(2));"
        "click(0); seen.push(order(0));"
        "const filter = document.querySelector('#filter'); filter.value = 'TREE';"
        "filter.dispatchEvent(new Event('input'));"
        "seen.push(document.querySelector('#left').textContent);"
        "document.title = seen.join('; ');"
    )
    path = tmp_path / "a.html"
    path.write_text(text.replace("</script>", clicks + "</script>"), encoding="utf-8")
    shown = subprocess.run(
        ["chromium", "--headless", "--no-sandbox", "--disable-gpu", "--disable-quic",
         "--no-first-run", "--disable-background-networking", "--disable-component-update",
         "--disable-sync", f"--user-data-dir={tmp_path / 'profile'}", "--dump-dom",
         path.as_uri()],
        capture_output=True, text=True, check=True, timeout=120,
    ).stdout  # fmt: skip
    title = re.search("<title>(.*?)</title>", shown).group(1)
    # Empty cells are last in both directions.
    assert title == (
        f"-1e-300|0.3|; 0.3|-1e-300|; 9|10|{2**53}; a &lt; b &amp; c|ga ann|tree; 1 shown"
    )

"""Everything that the report shows has a caption, and no caption is left over."""

import re
from pathlib import Path

from abradem.report.tables import TABLES

ROOT = Path(__file__).parents[2]
RULES = {path.stem: path.read_text() for path in (ROOT / "workflow" / "rules").glob("*.smk")}


def test_every_table_of_the_report_has_a_caption_and_no_other():
    text = RULES["report"]
    listed = text[text.index("TABLE_FILES = {") : text.index("localrules")]
    named = re.findall(r'"(\w+)": (?:rules\.|ROWS)', listed)
    assert sorted(named) == sorted(TABLES)
    assert all(caption.endswith(".") and len(caption) > 20 for caption in TABLES.values())


def test_every_caption_file_is_used_and_is_there():
    used = {name for text in RULES.values() for name in re.findall(r"report/(\w+)\.rst", text)}
    assert used == {path.stem for path in (ROOT / "workflow" / "report").glob("*.rst")}


def test_every_file_that_the_report_shows_names_its_caption():
    for text in RULES.values():
        for shown in re.findall(r"(?<!\w)report\((.*?)\n {8,12}\)", text, re.DOTALL):
            assert "caption=" in shown, shown

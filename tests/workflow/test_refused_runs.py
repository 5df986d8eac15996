"""A run that would fail at its end is refused before its first job, all problems at once."""

import importlib.util

import pytest
from copies import run_in, workflow_in
from tables import product_law

from abradem.quantities import SAMPLED_NAMES
from abradem.report.typeset import find_program


@pytest.fixture(scope="module")
def copied(tmp_path_factory):
    return workflow_in(tmp_path_factory.mktemp("refused"))


def refused(copied, *targets, **overlay):
    """The last lines of a run that has not begun."""
    status, lines = run_in(copied, *targets, overlay=overlay)
    assert status != 0
    assert not any('File "' in line or "Traceback" in line for line in lines), lines
    assert not list((copied / "results").rglob("*.parquet"))
    return lines


def test_all_problems_of_a_run_are_told_at_once(copied):
    lines = refused(
        copied, "learning", "results/smoke/export/case-99/wear.parquet", "movie", "paper",
        sampling={"blocks": 1, "cases_per_block": 6},
    )  # fmt: skip
    expected = [
        "case 99: there is no such case (allowed 0 ... 5)",
        "sampling.blocks and cases_per_block: 6 rows are too few to learn from (allowed from 8)",
    ]
    if importlib.util.find_spec("imageio_ffmpeg") is None:
        expected.append("film: films need the package imageio-ffmpeg: pip install -e '.[movie]'")
    if find_program() is None:
        expected.append("paper_pdf: no LaTeX is installed (looked for latexmk, tectonic, pdflatex)")
    assert lines[-len(expected) :] == expected


@pytest.mark.parametrize("rows", [1, 5])
def test_a_table_with_few_rows_is_one_line(copied, rows):
    table = product_law(24)[[*SAMPLED_NAMES, "wear_total_mean"]].head(rows)
    table.to_csv(copied / "few.csv", index=False)
    lines = refused(
        copied, "--dry-run", study="few", dataset={"external": "few.csv"},
        learning={"target": "wear_total_mean"},
    )  # fmt: skip
    assert lines[-1] == f"few.csv: {rows} rows are too few to learn from (allowed from 8)"
    assert sum("too few" in line for line in lines) == 1


@pytest.mark.parametrize("external", ["a" * 300 + ".csv", "folder/", "."])
def test_a_path_that_is_no_file_is_one_line(copied, external):
    lines = refused(copied, "--dry-run", study="few", dataset={"external": external})
    assert lines[-1].startswith(f"dataset.external: {external}: ")


def test_a_table_that_is_no_utf8_is_one_line(copied):
    (copied / "latin.csv").write_bytes("plate_angle,Dichte \xfc\n1,2\n".encode("latin-1"))
    lines = refused(copied, "--dry-run", study="few", dataset={"external": "latin.csv"})
    assert lines[-1].startswith("latin.csv: ")

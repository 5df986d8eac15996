"""Free text of the configuration is no pattern of Snakemake: braces in it are braces."""

import pytest
import yaml
from copies import run_in, workflow_in
from tables import product_law

from abradem.quantities import SAMPLED_NAMES

TEXTS = ["Wear by {DEM}", "{block}", "{{a}} {", "} {wildcards.case} {0}", "{a,\\d+}"]


@pytest.fixture(scope="module")
def copied(tmp_path_factory):
    return workflow_in(tmp_path_factory.mktemp("braces"))


@pytest.mark.parametrize("text", TEXTS)
def test_braces_in_the_metadata_of_a_study_are_no_wildcards(copied, text):
    overlay = {"publish": {"title": text, "creators": [text, "Ada"]}}
    status, said = run_in(copied, "--dry-run", "all", "publish", "provenance", overlay=overlay)
    assert status == 0, said
    if text == TEXTS[0]:
        status, said = run_in(copied, "results/smoke/config.yaml", overlay=overlay)
        assert status == 0, said
        written = yaml.safe_load((copied / "results/smoke/config.yaml").read_text())
        assert written["publish"]["title"] == text


@pytest.mark.parametrize("text", TEXTS)
def test_braces_in_the_path_and_the_columns_of_a_table_are_no_wildcards(copied, text):
    column = f"slope {text}"
    table = product_law(24)[[*SAMPLED_NAMES, "wear_total_mean"]]
    name = f"{text}, 'my_table_\".csv"
    table.rename(columns={"plate_angle": column}).to_csv(copied / name, index=False)
    overlay = {
        "study": "elsewhere",
        "dataset": {"external": name, "columns": {"plate_angle": column}},
        "learning": {"target": "wear_total_mean"},
    }
    status, said = run_in(copied, "--dry-run", overlay=overlay)
    assert status == 0, said
    assert not any("Missing input" in line for line in said)
    if text == TEXTS[0]:
        files = [f"results/elsewhere/{name}" for name in ("dataset.parquet", "rule_graph.parquet")]
        status, said = run_in(copied, *files, overlay=overlay)
        assert status == 0, said
        assert all((copied / file).is_file() for file in files)

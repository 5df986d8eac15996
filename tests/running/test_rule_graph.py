"""The graph of the workflow rules as a table."""

from pathlib import Path

import pandas as pd
import pytest

from abradem.running.rule_graph import from_dot, rule_graph, stages

ROOT = Path(__file__).parents[2]


def test_every_rule_has_the_file_it_stands_in_first():
    files = sorted((ROOT / "workflow" / "rules").glob("*.smk"))
    found = stages(files)
    assert found["simulate"] == "simulation" and found["dataset"] == "dataset"
    assert found["figure_generation"] == "figures" and found["wear_rates"] == "wear"


def test_the_graph_of_rules_is_a_table_of_pairs():
    dot = '0[label = "all"];\n1[label = "b\\nx: 1"];\n2[label = "a"];\n2 -> 1\n1 -> 0\n'
    graph = from_dot(dot, {"a": "first", "b": "second"})
    expected = pd.DataFrame({"rule": ["a", "b"], "stage": ["first", "second"], "needs": ["", "a"]})
    pd.testing.assert_frame_equal(graph, expected, check_dtype=False)


def test_a_workflow_that_is_wrong_is_one_line(tmp_path):
    snakefile = tmp_path / "Snakefile"
    snakefile.write_text("import sys\nsys.exit('no such study')\n")
    with pytest.raises(RuntimeError, match=r"snakemake --rulegraph failed: ") as error:
        rule_graph(snakefile, [])
    assert "\n" not in str(error.value)

"""Run times of the jobs of a study."""

from pathlib import Path

from abradem.running.run_times import run_times

ROOT = Path(__file__).parents[2]


def test_run_times_are_summed_by_rule_and_half_written_files_do_not_count(tmp_path):
    (tmp_path / "simulate").mkdir()
    for name, seconds in (("a", 2.0), ("b", 3.5)):
        (tmp_path / "simulate" / f"{name}.tsv").write_text(f"s\th:m:s\n{seconds}\t0:00:02\n")
    (tmp_path / "simulate" / "c.tsv").write_text("s\th:m:s\n")
    (tmp_path / "angles.tsv").write_text("s\th:m:s\n9.0\t0:00:09\n")
    (tmp_path / "half.tsv").write_text("")
    assert run_times(tmp_path) == [
        {"rule": "angles", "jobs": 1, "seconds": 9.0, "longest": 9.0},
        {"rule": "simulate", "jobs": 2, "seconds": 5.5, "longest": 3.5},
    ]
    assert run_times(tmp_path / "nothing") == []

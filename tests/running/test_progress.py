"""The line of progress counts finished, resumed and missing cases."""

import io
import logging
import os
import time
from dataclasses import replace

import pytest

from abradem.running.progress import BatchOfCases, Monitor, duration


class Batches:
    """Two batches of four cases each to be simulated, of twelve cases that a run needs."""

    def __init__(self, root):
        self.root = root
        self.stream = io.StringIO()
        self.monitor = Monitor(root / ".finished", self.stream)
        self.batches = {
            name: BatchOfCases(root / f"{name}.parquet", root / ".finished" / name, [30.0] * 4)
            for name in "ab"
        }

    def begin(self):
        self.monitor.begin(self.batches, 12)

    def run(self, name, resumed=0, finished=0):
        folder = self.batches[name].finished
        folder.mkdir(parents=True, exist_ok=True)
        (folder / "started").write_text(str(resumed))
        for case in range(finished):
            (folder / f"{case}.runs.parquet").write_text("")

    def end(self, name):
        self.batches[name].runs.write_text("")

    def age(self, path, seconds=100.0):
        os.utime(path, (time.time() - seconds,) * 2)


@pytest.fixture
def study(tmp_path):
    return Batches(tmp_path)


@pytest.fixture
def clock(monkeypatch):
    """Sets the time since the start of the test, s."""
    began = time.monotonic()

    def at(seconds):
        monkeypatch.setattr(time, "monotonic", lambda: began + seconds)

    at(0.0)
    return at


def test_cases_of_batches_that_need_not_run_count_as_done(study):
    study.begin()
    assert study.monitor.count() == 4


@pytest.mark.parametrize(("total", "done"), [(8, 0), (9, 1), (12, 4)])
def test_only_the_cases_that_a_run_needs_are_counted(study, total, done):
    study.monitor.begin(study.batches, total)
    assert study.monitor.line() == f"simulations: {done} of {total} cases done"


def test_finished_cases_of_a_running_batch_count(study):
    study.begin()
    study.run("a", finished=3)
    assert study.monitor.count() == 7


def test_a_finished_batch_counts_all_its_cases(study):
    study.begin()
    study.end("a")
    assert study.monitor.count() == 8
    study.run("b", finished=1)
    assert study.monitor.count() == 9


def test_an_outdated_table_of_a_batch_does_not_count(study):
    study.end("a")
    study.age(study.batches["a"].runs)
    study.begin()
    assert study.monitor.count() == 4


def test_cases_kept_by_a_killed_run_count_once_their_batch_starts_again(study):
    study.run("a", finished=2)
    study.age(study.batches["a"].finished / "started")
    study.begin()
    assert study.monitor.count() == 4
    study.run("a", resumed=2)
    assert study.monitor.count() == 6


def test_cases_of_a_killed_run_do_not_shorten_the_time_left(study):
    study.begin()
    study.run("a", resumed=2, finished=2)
    assert study.monitor.line() == "simulations: 6 of 12 cases done"


def test_the_time_left_follows_the_rate_of_this_run(study, clock):
    study.begin()
    clock(60.0)
    study.run("a", finished=2)
    assert study.monitor.line() == "simulations: 6 of 12 cases done, about 3 min left"


def test_the_time_left_counts_what_the_cases_cost(study, clock):
    for name, seconds in (("a", [10.0, 20.0, 30.0, 30.0]), ("b", [5.0, 5.0, 10.0, 10.0])):
        study.batches[name] = replace(study.batches[name], seconds=seconds)
    study.begin()
    study.run("b", finished=2)
    clock(60.0)
    # 10 s of computing were worked off in 60 s, 110 s are left.
    assert study.monitor.line() == "simulations: 6 of 12 cases done, about 11 min left"
    study.end("a")
    assert study.monitor.line() == "simulations: 10 of 12 cases done, about 12 s left"


def test_the_time_left_falls_while_an_expensive_case_runs(study, clock):
    """A case that takes most of a run counts while it runs, up to its estimate."""
    study.batches["a"] = replace(study.batches["a"], seconds=[300.0, 20.0, 20.0, 20.0])
    study.begin()
    study.run("a")
    study.monitor.line()
    lines = []
    for after in (100.0, 200.0, 300.0, 400.0):
        clock(after)
        lines.append(study.monitor.line().rpartition("about ")[2])
    assert lines == ["6 min left", "5 min left", "3 min left", "4 min left"]


def test_no_time_left_is_told_while_jobs_start(study, clock):
    study.batches["a"] = replace(study.batches["a"], seconds=[0.01, 300.0, 20.0, 20.0])
    study.begin()
    clock(5.0)
    study.run("a", finished=1)
    assert study.monitor.line() == "simulations: 5 of 12 cases done"
    clock(10.0)
    assert study.monitor.line() == "simulations: 5 of 12 cases done, about 15 min left"


def test_the_last_line_says_how_long_it_took(study):
    study.begin()
    study.end("a")
    study.end("b")
    assert study.monitor.line() == "simulations: 12 of 12 cases done in 0 s"


def test_a_log_gets_plain_lines_and_the_last_one_once(study):
    study.monitor.interval = 0.01
    study.monitor.start(study.batches, 12)
    study.end("a")
    study.end("b")
    time.sleep(0.1)
    study.monitor.stop()
    lines = study.stream.getvalue().splitlines()
    assert lines[-1] == "simulations: 12 of 12 cases done in 0 s"
    assert lines.count(lines[-1]) == 1
    assert "\r" not in study.stream.getvalue()


def test_a_terminal_gets_one_line_renewed_in_place(study):
    study.monitor.in_place = True
    study.monitor.interval = 0.01
    study.monitor.start(study.batches, 12)
    time.sleep(0.05)
    study.monitor.stop()
    text = study.stream.getvalue()
    assert text.count("\r") >= 2
    assert text.count("\n") == 1 and text.endswith("\n")


def test_a_message_of_another_gets_the_line_of_the_terminal(study):
    study.monitor.in_place = True
    study.monitor.interval = 0.01
    study.monitor.start(study.batches, 12)
    time.sleep(0.05)
    study.monitor.interval = 60.0
    time.sleep(0.05)
    logging.getLogger("snakemake.logging").error("said")
    assert study.stream.getvalue().endswith("\r\x1b[2K")
    study.monitor.stop()


def test_nothing_is_printed_or_left_if_nothing_is_simulated(study, tmp_path):
    study.monitor.start({}, 12)
    study.monitor.stop()
    assert study.stream.getvalue() == ""
    assert list(tmp_path.iterdir()) == []


def test_no_file_of_the_monitor_is_left(study, tmp_path):
    study.monitor.start(study.batches, 12)
    study.monitor.stop()
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("seconds", "words"),
    [(0.4, "0 s"), (59.0, "59 s"), (600.0, "10 min"), (7500.0, "2 h 05 min")],
)
def test_durations_read_as_one_would_say_them(seconds, words):
    assert duration(seconds) == words

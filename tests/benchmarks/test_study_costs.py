"""Cost of a finished study and accuracy of its estimate, compared with hand calculations."""

import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import order
import pandas as pd
import pytest
import study
import windows

from abradem.config import read_config, sampled_ranges, setup_dict, to_yaml
from abradem.dem import Interaction, simulate
from abradem.dem.steady import batch_means
from abradem.sampling import cost
from abradem.sampling.draw import block_cases
from abradem.store.tables import read_table, write_table
from abradem.verification.scenes import Scene, solid

ROOT = Path(__file__).parents[2]


@pytest.fixture
def finished(tmp_path):
    """A study of four jobs of 30 cases; each case took three times its estimate."""
    overlay = tmp_path / "overlay.yaml"
    overlay.write_text(
        "study: made_up\nsampling: {blocks: 2, cases_per_block: 60}\n"
        "simulation: {cases_per_job: 30}\n"
    )
    config = read_config(ROOT / "config.yaml", overlay)
    folder = tmp_path / "results" / "made_up"
    for block in range(2):
        cases = block_cases(config.seed, block, 60, config.sampling.method, sampled_ranges(config))
        write_table(cases, folder / "cases" / f"block-{block:03d}.parquet")
        seconds = 3.0 * cost.case_seconds(cases, setup_dict(config))
        for batch, (start, stop) in enumerate(config.batches):
            job = f"block-{block:03d}-batch-{batch:03d}"
            part = cases.iloc[start:stop]
            runs = part[["case_id"]].assign(
                status="ok", simulated_time=6.0, time_step=2e-6, released=500
            )
            runs.loc[runs["case_id"] == 7, "status"] = "rejected: too soft"
            times = part[["case_id"]].assign(processor_time=seconds[start:stop])
            write_table(runs, folder / "runs" / f"{job}.parquet")
            write_table(times, folder / "benchmarks" / "cases" / f"{job}.parquet")
            series = part[["case_id"]].loc[part.index.repeat(2)]
            # From 0 to 80 particles: 40 present on average.
            series = series.assign(particles_present=np.tile([0, 80], len(part)))
            write_table(series, folder / "series" / f"{job}.parquet")
            for name in ("maps", "wear_rates"):
                write_table(part[["case_id"]], folder / name / f"{job}.parquet")
            record = folder / "benchmarks" / "simulate" / f"{job}.tsv"
            record.parent.mkdir(parents=True, exist_ok=True)
            record.write_text(f"s\tmax_rss\n100.0\t{250 + batch}.5\n")
    (folder / "config.yaml").write_text(to_yaml(config))
    return folder


def test_the_figures_of_a_study_are_those_of_its_tables(finished, monkeypatch, capsys):
    # Jobs of another study in the folder are not counted.
    stale = finished / "benchmarks" / "cases" / "block-000-batch-002.parquet"
    write_table(pd.DataFrame({"case_id": [1], "processor_time": [1e6]}), stale)
    monkeypatch.setattr(sys, "argv", ["study.py", str(finished)])
    study.main()
    said = capsys.readouterr().out
    config = read_config(finished / "config.yaml")
    guess = np.concatenate(
        [cost.case_seconds(read_table(path), setup_dict(config))
         for path in sorted((finished / "cases").glob("*"))]
    )  # fmt: skip
    jobs = 3.0 * guess.reshape(4, 30).sum(axis=1)
    assert "cases: 120, simulated: 119" in said
    # 120 cases of 6 s in steps of 2 us, 500 particles each.
    assert "simulated: 720 s, 0.36 billion steps" in said
    assert "particles released: 0.06 million" in said
    # 40 of them in each of 3 million steps of a case; the most expensive hundredth is one case.
    most_expensive = 3.0 * guess.max()
    assert (
        "particles present times steps: 14 billion; in the most expensive hundredth 0 billion"
        in said
    )
    assert f"of {1e9 * most_expensive / (40 * 3e6):.0f} ns each" in said
    more = 100.0 * (400.0 / jobs.sum() - 1.0)
    assert f"{more:.1f} % more than their cases took" in said
    assert f"computing: {jobs.sum():.0f} s" in said
    assert f"jobs: 4, the most expensive {jobs.max():.0f} s" in said and "400 s on the wall" in said
    assert "at most 252 MB" in said


def test_an_unfinished_study_is_refused(finished):
    (finished / "runs" / "block-001-batch-000.parquet").unlink()
    with pytest.raises(SystemExit, match=r"block-001-batch-000.parquet is missing"):
        study.read_study(finished)
    (finished / "config.yaml").unlink()
    with pytest.raises(SystemExit, match=r"config.yaml is missing"):
        study.read_study(finished)


def test_two_cores_take_the_jobs_in_the_order_given():
    seconds = np.array([1.0, 1.0, 1.0, 3.0])
    assert order.makespan(seconds, np.arange(4)) == 4.0
    assert order.makespan(seconds, np.argsort(-seconds)) == 3.0
    assert order.makespan(seconds, np.arange(4), cores=1) == 6.0


def test_constants_are_found_again_from_times_made_with_them(finished, capsys):
    timed = order.read_times(finished)
    assert len(timed.seconds) == 119
    order.print_comparison(timed)
    assert "of ranks 1.00" in capsys.readouterr().out
    assert timed.guess().sum() == pytest.approx(timed.seconds.sum() / 3.0)
    others = cost.COSTS._replace(particle=3e-5, contact=0.3, tilt=-5.0, restitution=2.0)
    timed = timed._replace(seconds=timed.guess(others))
    assert timed.guess(order.fit([timed])) == pytest.approx(timed.seconds, rel=0.02)


@pytest.mark.parametrize("target", [0.2, 0.06])
def test_a_replay_of_the_stop_rule_stops_where_the_simulation_did(target):
    scene = Scene(
        particle=solid(5e9, 0.25, 2500.0), radius=0.03, interaction=Interaction(0.5, 0.45, 0.05)
    )
    for angle in (30.0, 2.0):
        case = scene.case(plate_angle=angle, particle_velocity_y=-3.0, seed=3)
        setup = scene.setup(window=1.0, max_time=30.0, target_stderr=target)
        result = simulate(case, setup)
        assert result.simulated_time < 29.0
        longer = simulate(case, replace(setup, duration=result.simulated_time + 2.0))
        rate, stderr, end = windows.stopped_rate(
            longer.time, longer.worn[:, 0], longer.present, setup, result.release_interval
        )
        # The time between releases is a quotient here, so the error differs by rounding.
        assert end == result.simulated_time and stderr == pytest.approx(result.stderr, rel=1e-9)
        known = batch_means(
            result.time, result.worn[:, 0], result.steady_from,
            release_interval=result.release_interval,
        )  # fmt: skip
        assert rate == pytest.approx(known.rate, rel=1e-9)

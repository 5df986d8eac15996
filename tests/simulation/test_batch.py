"""Batches: division into batches, tables, and resumption after an interruption."""

import dataclasses
import math
import os
import threading
import time

import numpy as np
import pytest
from cases import SETUP, table_of_cases
from hypothesis import given
from hypothesis import strategies as st

import abradem.dem.warm
from abradem.config.batches import batches_of_block
from abradem.dem.model import Case, Setup, SimulationResult
from abradem.dem.surface import CELL_SUMS
from abradem.geometry.build import surface_of
from abradem.geometry.kinds import Plates
from abradem.geometry.shapes import Rectangle
from abradem.quantities import SAMPLED
from abradem.simulation import batch
from abradem.simulation.batch import FILES, STARTED, TABLES, case_key, run_batch
from abradem.store.tables import read_table


def result_of(case, setup, status="ok"):
    rng = np.random.default_rng(int(case.particle_density))
    worn = rng.random((5, 3)).cumsum(axis=0)
    # Some facets are worn in some of the parts only.
    parts = rng.random((10, 3, *setup.facets)) * (rng.random((10, 1, *setup.facets)) < 0.5)
    numbers = {
        field.name: 0.1 for field in dataclasses.fields(SimulationResult) if field.type == "float"
    }
    others = {
        "case": case, "setup": setup, "status": status, "time": np.arange(5.0), "worn": worn,
        "delivered_mass": np.arange(5.0), "present": np.arange(5),
        "facet_wear": parts.sum(axis=0), "facet_wear_parts": parts,
        "facet_wear_all": rng.random((3, *setup.facets)), "window": (1.0, 2.0),
        "released": 5, "removed": 4, "energy": {},
    }  # fmt: skip
    for field in dataclasses.fields(SimulationResult):
        others.setdefault(field.name, numbers.get(field.name, True))
    return SimulationResult(**others)


@pytest.fixture
def engine(monkeypatch):
    """A simulation that counts its calls and can fail at a given case."""
    calls = []

    def simulate(case, setup):
        calls.append(case)
        if len(calls) == engine.fails_at:
            raise engine.error
        return result_of(case, setup)

    engine.fails_at, engine.error = None, KeyboardInterrupt()
    engine.calls = calls
    monkeypatch.setattr(abradem.dem, "simulate", simulate, raising=False)
    return engine


def run(folder, cases=None, setup=SETUP, code="code"):
    outputs = {name: folder / f"{name}.parquet" for name in FILES}
    cases = table_of_cases() if cases is None else cases
    run_batch(cases, setup, outputs, folder / ".finished" / "batch", code)
    return {name: read_table(path) for name, path in outputs.items()}


# The plan


@given(st.integers(1, 5000), st.one_of(st.just("auto"), st.integers(1, 6000)))
def test_batches_cover_a_block_without_overlap(cases, setting):
    plan = batches_of_block(cases, setting)
    assert [case for start, stop in plan for case in range(start, stop)] == list(range(cases))


def test_one_case_per_job_is_possible():
    assert batches_of_block(3, 1) == [(0, 1), (1, 2), (2, 3)]


def test_auto_makes_ten_jobs_of_a_block_until_jobs_grow_too_long():
    assert len(batches_of_block(100, "auto")) == 10
    assert len(batches_of_block(1000, "auto")) == 10
    assert len(batches_of_block(10_000, "auto")) == 100


# The tables


def test_every_case_has_a_row_in_runs(engine, tmp_path):
    tables = run(tmp_path, table_of_cases(rejected=[1]))
    assert tables["runs"]["case_id"].tolist() == [0, 1, 2, 3]
    assert tables["runs"]["status"].tolist() == ["ok", "rejected: too soft", "ok", "ok"]


def test_a_rejected_case_is_not_simulated_and_has_no_series(engine, tmp_path):
    tables = run(tmp_path, table_of_cases(rejected=[1]))
    assert len(engine.calls) == 3
    for name in ("series", "maps", "parts"):
        assert set(tables[name]["case_id"]) == {0, 2, 3}
    row = tables["runs"].set_index("case_id").loc[1]
    assert row["simulated_time"] == 0.0 and math.isnan(row["window_start"])


def test_the_time_of_each_case_is_kept_over_an_interruption(engine, tmp_path, monkeypatch):
    """The third simulation is interrupted; its 3 s and the loading of kernels are not counted."""
    now, spent = [0.0], iter([1.0, 2.0, 3.0, 4.0, 5.0])
    simulate = abradem.dem.simulate

    def slow(case, setup):
        now[0] += next(spent)
        return simulate(case, setup)

    def load(stepping, on_surface):
        now[0] += 100.0

    monkeypatch.setattr(abradem.dem, "simulate", slow)
    monkeypatch.setattr(abradem.dem.warm, "load", load)
    monkeypatch.setattr(time, "process_time", lambda: now[0])
    engine.fails_at = 3
    with pytest.raises(KeyboardInterrupt):
        run(tmp_path)
    times = run(tmp_path)["times"]
    assert times["case_id"].tolist() == [0, 1, 2, 3]
    assert times["processor_time"].tolist() == [1.0, 2.0, 4.0, 5.0]


def test_threads_reach_the_engine_and_change_nothing_that_is_kept(engine, tmp_path, monkeypatch):
    """Of an interrupted batch, cases simulated with other threads are kept."""
    given, loaded, outputs = [], [], {name: tmp_path / f"{name}.parquet" for name in FILES}

    def simulate(case, setup, threads=1):
        given.append(threads)
        if len(given) == 3:
            raise KeyboardInterrupt
        return result_of(case, setup)

    monkeypatch.setattr(abradem.dem, "simulate", simulate)
    monkeypatch.setattr(abradem.dem.warm, "load", lambda stepping, *_: loaded.append(stepping))
    with pytest.raises(KeyboardInterrupt):
        run_batch(table_of_cases(), SETUP, outputs, tmp_path / "batch", "code", threads=2)
    assert loaded[:2] == ["islands", "parallel"]
    run_batch(table_of_cases(), SETUP, outputs, tmp_path / "batch", "code")
    assert given == [2, 2, 2, 1, 1]


def test_a_batch_of_rejected_cases_only_is_written(engine, tmp_path):
    abradem.dem.warm.load.cache_clear()
    tables = run(tmp_path, table_of_cases(2, rejected=[0, 1]))
    assert abradem.dem.warm.load.cache_info().currsize == 0, "kernels are loaded for nothing"
    assert len(tables["runs"]) == 2 and len(tables["series"]) == 0
    assert tables["maps"].dtypes["facet_x"] == tables["parts"].dtypes["facet_x"] == np.int32
    assert tables["runs"]["window_parts"].tolist() == [0, 0]


def test_what_the_engine_refuses_is_a_status_and_the_others_go_on(engine, tmp_path):
    engine.fails_at, engine.error = 2, ValueError("step too long")
    tables = run(tmp_path)
    assert tables["runs"]["status"].tolist() == ["ok", "refused: step too long", "ok", "ok"]


def test_numbers_that_fail_are_a_status_and_the_others_go_on(engine, tmp_path):
    engine.fails_at, engine.error = 3, ZeroDivisionError("division by zero")
    tables = run(tmp_path)
    failed = "failed: ZeroDivisionError: division by zero"
    assert tables["runs"]["status"].tolist() == ["ok", "ok", failed, "ok"]
    assert set(tables["series"]["case_id"]) == {0, 1, 3}


@pytest.mark.parametrize(
    ("error", "line"),
    [
        (MemoryError(), "case 1: too little memory: MemoryError"),
        (KeyError("unforeseen"), "case 1: 'unforeseen'"),
    ],
)
def test_what_another_attempt_may_mend_becomes_no_result(engine, tmp_path, error, line):
    engine.fails_at, engine.error = 2, error
    with pytest.raises(RuntimeError) as raised:
        run(tmp_path)
    assert str(raised.value) == line
    assert not list(tmp_path.glob("*.parquet"))
    # The other cases are kept, so that only the one is repeated.
    assert len(engine.calls) == 4
    engine.fails_at = None
    tables = run(tmp_path)
    assert len(engine.calls) == 5 and (tables["runs"]["status"] == "ok").all()


def test_tables_hold_what_the_simulation_returned(engine, tmp_path):
    cases = table_of_cases()
    tables = run(tmp_path, cases)
    expected = result_of(batch.Case.from_row(cases.iloc[2]), Setup.from_dict(SETUP))
    series = tables["series"].query("case_id == 2")
    assert np.array_equal(series[["worn_total", "worn_sliding", "worn_friction"]], expected.worn)
    maps = tables["maps"].query("case_id == 2")
    shown = np.zeros(expected.facet_wear.shape)
    for index, measure in enumerate(("total", "sliding", "friction")):
        shown[index, maps["facet_x"], maps["facet_z"]] = maps[f"wear_{measure}"]
    assert np.array_equal(shown, expected.facet_wear)
    parts = tables["parts"].query("case_id == 2")
    shown = np.zeros(expected.facet_wear_parts.shape)
    for index, measure in enumerate(("total", "sliding", "friction")):
        column = parts[f"part_wear_{measure}"]
        assert column.dtype == np.float32
        shown[parts["window_part"], index, parts["facet_x"], parts["facet_z"]] = column
    # Twelve significant bits.
    np.testing.assert_allclose(shown, expected.facet_wear_parts, rtol=2.0**-12)
    assert not np.array_equal(shown, expected.facet_wear_parts)
    assert tables["runs"]["window_parts"].tolist() == [10] * 4
    # Where there is no wear there is no row.
    assert len(parts) == np.count_nonzero(expected.facet_wear_parts[:, 0])


def test_a_surface_without_a_complete_window_has_no_parts():
    """A simulation that is shorter than the window; the cells of a surface are one axis."""
    cases = table_of_cases()
    result = result_of(batch.Case.from_row(cases.iloc[0]), Setup.from_dict(SETUP))
    surface = surface_of(Plates((Rectangle(0.2, 0.2, 30.0),)), 0.1)
    cells = len(surface.triangles)
    result = dataclasses.replace(
        result,
        setup=dataclasses.replace(result.setup, surface=surface),
        facet_wear=np.zeros((3, cells)),
        facet_wear_parts=np.empty((0, 3, cells)),
        cell_sums=np.zeros((len(CELL_SUMS), cells)),
    )
    tables = batch.result_tables(cases.iloc[0], result)
    assert len(tables["parts"]) == 0 and len(tables["maps"]) == cells > 4
    assert tables["runs"]["window_parts"].tolist() == [0]


# Interruptions


def test_an_interrupted_batch_keeps_its_cases_and_ends_with_the_same_bytes(engine, tmp_path):
    run(tmp_path / "whole")
    engine.calls.clear()
    engine.fails_at = 3
    with pytest.raises(KeyboardInterrupt):
        run(tmp_path / "cut")
    assert not list((tmp_path / "cut").glob("*.parquet"))
    engine.calls.clear()
    engine.fails_at = None
    run(tmp_path / "cut")
    assert len(engine.calls) == 2
    for name in TABLES:
        whole = (tmp_path / "whole" / f"{name}.parquet").read_bytes()
        assert (tmp_path / "cut" / f"{name}.parquet").read_bytes() == whole


@pytest.mark.parametrize("change", ["code", "setup", "cases"])
def test_cases_finished_under_other_conditions_are_not_used(engine, tmp_path, change):
    engine.fails_at = 3
    with pytest.raises(KeyboardInterrupt):
        run(tmp_path)
    engine.calls.clear()
    engine.fails_at = None
    cases = table_of_cases()
    cases["restitution"] *= 0.9
    run(tmp_path, **{
        "code": {"code": "other"}, "setup": {"setup": {**SETUP, "window": 2.0}},
        "cases": {"cases": cases},
    }[change])  # fmt: skip
    assert len(engine.calls) == 4


def test_a_case_half_written_is_simulated_again(engine, tmp_path):
    engine.fails_at = 2
    with pytest.raises(KeyboardInterrupt):
        run(tmp_path)
    (runs,) = (tmp_path / ".finished" / "batch").glob("*.runs.parquet")
    runs.unlink()
    engine.calls.clear()
    engine.fails_at = None
    run(tmp_path)
    assert len(engine.calls) == 4


@pytest.mark.parametrize("name", FILES)
def test_a_damaged_kept_case_is_simulated_again(engine, tmp_path, name):
    engine.fails_at = 3
    with pytest.raises(KeyboardInterrupt):
        run(tmp_path)
    (kept, *_) = (tmp_path / ".finished" / "batch").glob(f"*.{name}.parquet")
    # As after a power failure.
    kept.write_bytes(b"")
    engine.calls.clear()
    engine.fails_at = None
    tables = run(tmp_path)
    assert len(engine.calls) == 3 and len(tables["runs"]) == 4


def renamed(content):
    """A name of a column in the footer, which no checksum of Parquet covers."""
    return content.replace(b"case_id", b"case_iD")


def retyped(content):
    """The long name of a column, which nothing reads."""
    return content.replace(b"long_name", b"long_nama")


def flipped(content):
    middle = len(content) // 2
    return content[:middle] + bytes([content[middle] ^ 1]) + content[middle + 1 :]


@pytest.mark.parametrize("name", [*FILES, "sums"])
@pytest.mark.parametrize("harm", [renamed, retyped, flipped, lambda content: content[:-9]])
def test_a_kept_case_with_any_damage_is_simulated_again(engine, tmp_path, name, harm):
    """Also one that can still be read, with another name or value."""
    run(tmp_path / "whole")
    engine.calls.clear()
    engine.fails_at = 3
    with pytest.raises(KeyboardInterrupt):
        run(tmp_path / "cut")
    kept = sorted((tmp_path / "cut" / ".finished" / "batch").glob(f"*.{name}.*"))[0]
    content = kept.read_bytes()
    if harm(content) == content:
        pytest.skip("has nothing of the kind")
    kept.write_bytes(harm(content))
    engine.calls.clear()
    engine.fails_at = None
    run(tmp_path / "cut")
    assert len(engine.calls) == 3
    for table in TABLES:
        whole = (tmp_path / "whole" / f"{table}.parquet").read_bytes()
        assert (tmp_path / "cut" / f"{table}.parquet").read_bytes() == whole


def test_a_kept_case_whose_tables_are_those_of_another_is_simulated_again(engine, tmp_path):
    engine.fails_at = 3
    with pytest.raises(KeyboardInterrupt):
        run(tmp_path)
    first, second = sorted((tmp_path / ".finished" / "batch").glob("*.runs.parquet"))
    first.write_bytes(second.read_bytes())
    engine.calls.clear()
    engine.fails_at = None
    assert sorted(run(tmp_path)["runs"]["case_id"]) == [0, 1, 2, 3]
    assert len(engine.calls) == 3


def test_a_clock_that_jumps_changes_nothing(engine, tmp_path):
    """Files of an interrupted batch are used even if they are dated 1970 or 2096."""
    run(tmp_path / "whole")
    engine.fails_at = 7
    with pytest.raises(KeyboardInterrupt):
        run(tmp_path / "cut")
    for number, path in enumerate(sorted((tmp_path / "cut").rglob("*.*"))):
        os.utime(path, [(0.0, 0.0), (4e9, 4e9)][number % 2])
    run(tmp_path / "cut")
    assert len(engine.calls) == 4 + 3 + 2
    for name in TABLES:
        whole = (tmp_path / "whole" / f"{name}.parquet").read_bytes()
        assert (tmp_path / "cut" / f"{name}.parquet").read_bytes() == whole


def test_two_processes_at_the_same_batch_take_turns(engine, tmp_path):
    """The second starts while the first is at work, as after a kill that left a job alive."""
    turns = []
    simulate = abradem.dem.simulate

    def slow(case, setup):
        turns.append(threading.get_ident())
        time.sleep(0.02)
        return simulate(case, setup)

    abradem.dem.simulate = slow
    threads = [threading.Thread(target=run, args=(tmp_path,)) for _ in range(3)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert turns == sorted(turns, key=turns.index) and len(turns) == 12
    assert sorted(path.name for path in tmp_path.glob("*.parquet")) == [
        "maps.parquet", "parts.parquet", "runs.parquet", "series.parquet", "times.parquet",
    ]  # fmt: skip
    assert not list((tmp_path / ".finished").iterdir())


def test_nothing_but_the_tables_is_left(engine, tmp_path):
    run(tmp_path)
    assert not (tmp_path / ".finished" / "batch").exists()
    assert sorted(path.name for path in tmp_path.glob("*.*")) == [
        ".finished", "maps.parquet", "parts.parquet", "runs.parquet", "series.parquet",
        "times.parquet",
    ]  # fmt: skip


def test_a_batch_tells_how_many_cases_it_took_over(engine, tmp_path):
    engine.fails_at = 3
    with pytest.raises(KeyboardInterrupt):
        run(tmp_path)
    folder = tmp_path / ".finished" / "batch"
    assert (folder / STARTED).read_text() == "0" and batch.finished_cases(folder) == 2
    engine.fails_at = 4
    with pytest.raises(KeyboardInterrupt):
        run(tmp_path)
    assert batch.resumed_cases(folder) == 2


# Cases and set-ups as plain values


def test_a_key_changes_with_every_value_of_a_case():
    row = table_of_cases(1).iloc[0].to_dict()
    keys = {case_key(row, SETUP, "")}
    for name in (*(q.name for q in SAMPLED), "seed", "case_id"):
        keys.add(case_key({**row, name: row[name] + 1}, SETUP, ""))
    assert len(keys) == len(SAMPLED) + 3


def test_a_row_becomes_the_case_of_its_values():
    row = table_of_cases(1).iloc[0]
    case = batch.Case.from_row(row)
    assert isinstance(case, Case) and case.seed == 10
    assert case.restitution == row["restitution"]


def test_plain_values_become_the_set_up_they_describe():
    pair = {"restitution": 0.5, "static_friction": 0.3, "rolling_friction": 0.1}
    setup = Setup.from_dict({"contact": {"normal": "nominal_clipped"}, "pair_interaction": pair})
    assert setup.contact.normal == "nominal_clipped" and setup.pair_interaction.restitution == 0.5
    assert Setup.from_dict({}) == Setup()

"""Sweeps: all combinations in order, the rates of the engine or of a surrogate, the picture."""

import subprocess
import sys

import numpy as np
import pandas as pd
import pytest
from flat_surrogate import flat_prediction, write_flat_surrogate
from straight_engine import RATE, straight_line
from workers import has_ended

import abradem
import abradem.dem
from abradem.cases.kept_rows import KeptRows
from abradem.cases.sweep import MOST_CASES, combinations, predict_cases, simulate_cases
from abradem.dem.model import Setup
from abradem.figures.sweep import sweep_figure
from abradem.quantities import SAMPLED_NAMES, stderr_column
from abradem.store.errors import TableError
from abradem.surrogate.groups import Jet
from abradem.surrogate.model import Surrogate

CASE = {name: getattr(abradem.Case(), name) for name in SAMPLED_NAMES}
SWEPT = {"plate_angle": (0.0, 30.0, 60.0), "particle_radius": (0.02, 0.03)}
SETUP = {"facet_size": 0.03, "window": 2.0, "max_time": 4.0}


@pytest.fixture
def cases():
    return combinations({**CASE, **SWEPT})


def test_all_combinations_are_there_in_order_the_last_fastest():
    found = combinations({"plate_angle": (0.0, 30.0), "restitution": 0.5, "factory_angle": (-9, 0)})
    expected = pd.DataFrame(
        {
            "plate_angle": [0.0, 0.0, 30.0, 30.0],
            "restitution": [0.5] * 4,
            "factory_angle": [-9.0, 0.0, -9.0, 0.0],
        }
    )
    pd.testing.assert_frame_equal(found, expected)


def test_too_many_combinations_are_refused():
    many = range(200)
    with pytest.raises(ValueError, match=rf"has 8000000 cases \(allowed {MOST_CASES}\)"):
        combinations({"plate_angle": many, "restitution": many, "factory_angle": many})


def test_every_case_is_simulated_with_its_values_and_the_seed(monkeypatch, cases):
    asked = []

    def simulate(case, setup):
        asked.append(case)
        # A case that ends early has no rates.
        status = "more than 64 particles at once" if case.plate_angle == 60.0 else "ok"
        return straight_line(case, setup, status=status)

    monkeypatch.setitem(vars(abradem.dem), "simulate", simulate)
    done = []
    table = simulate_cases(cases, SETUP, 7, {"element_size": 0.06}, finished=done.append)
    assert [(case.plate_angle, case.particle_radius, case.seed) for case in asked] == [
        (angle, radius, 7) for angle in (0.0, 30.0, 60.0) for radius in (0.02, 0.03)
    ]
    assert done == [1, 2, 3, 4, 5, 6]
    mean = 1e3 * CASE["archard_constant"] * RATE / 0.09
    np.testing.assert_allclose(table["wear_total_mean"], [mean] * 4 + [np.nan] * 2)
    # The elements of 60 mm are rows 2 i - 1 and 2 i of a ramp of ten.
    np.testing.assert_allclose(table["wear_friction_max"][:4], mean * 9.5 / 5.5)
    assert table["status"].tolist() == ["ok"] * 4 + ["more than 64 particles at once"] * 2
    assert table["quality"].tolist()[4:] == ["", ""]


def test_a_case_that_cannot_be_simulated_says_why_and_the_others_go_on(monkeypatch):
    monkeypatch.setitem(vars(abradem.dem), "simulate", straight_line)
    table = simulate_cases(combinations({**CASE, "particle_radius": (0.02, 0.09)}),
                           SETUP | {"plate_width": 0.15}, 1)  # fmt: skip
    assert table["status"][0] == "ok" and np.isfinite(table["wear_total_max"][0])
    assert table["status"][1].startswith("rejected: particle of radius 0.09 m is wider than")
    assert np.isnan(table["wear_total_max"][1])


def test_the_number_of_processes_changes_no_bit_and_the_rates_are_those_of_simulate():
    setup = {"facet_size": 0.15, "window": 0.3, "max_time": 1.0, "number_rate": 60.0,
             "mass_rate": None}  # fmt: skip
    values = {**CASE, "particle_velocity_y": -8.0, "particle_radius": 0.03}
    cases = combinations({**values, "plate_angle": (30.0, 50.0)})
    one, two = (simulate_cases(cases, setup, 4, cores=cores) for cores in (1, 2))
    pd.testing.assert_frame_equal(one, two, check_exact=True)
    for _, row in one.iterrows():
        case = abradem.Case(**{**values, "plate_angle": row["plate_angle"]}, seed=4)
        alone = abradem.simulate(case, Setup(**setup)).wear_rate("friction", "max")
        column = "wear_friction_max"
        assert (row[column], row[stderr_column(column)]) == alone and row[column] > 0.0


def interrupted(monkeypatch, cases, path, after):
    """Angles and radii simulated by a sweep that is interrupted after some cases."""
    asked = []

    def simulate(case, setup):
        if len(asked) == after:
            raise KeyboardInterrupt
        asked.append((case.plate_angle, case.particle_radius))
        return straight_line(case, setup)

    monkeypatch.setitem(vars(abradem.dem), "simulate", simulate)
    with pytest.raises(KeyboardInterrupt):
        simulate_cases(cases, SETUP, 7, kept=KeptRows(path, "code"))
    return asked


def test_an_interrupted_sweep_goes_on_and_ends_in_the_same_bits(monkeypatch, cases, tmp_path):
    path = tmp_path / "s.csv.finished"
    first = interrupted(monkeypatch, cases, path, 3)
    # A kill in the midst of a line.
    with open(path, "ab") as file:
        file.write(b'{"key": "')
    second = interrupted(monkeypatch, cases, path, 2)
    third = []

    def simulate(case, setup):
        third.append((case.plate_angle, case.particle_radius))
        return straight_line(case, setup)

    monkeypatch.setitem(vars(abradem.dem), "simulate", simulate)
    done = []
    table = simulate_cases(cases, SETUP, 7, finished=done.append, kept=KeptRows(path, "code"))
    every = list(zip(cases["plate_angle"], cases["particle_radius"], strict=True))
    assert [*first, *second, *third] == every and len(third) == 1 and done == [5, 6]
    pd.testing.assert_frame_equal(table, simulate_cases(cases, SETUP, 7), check_exact=True)


def test_a_full_disk_and_a_folder_are_named(tmp_path):
    full = tmp_path / "s.csv.finished"
    full.symlink_to("/dev/full")
    with (
        pytest.raises(OSError, match=f"No space left on device: '{full}'"),
        KeptRows(full, "code") as kept,
    ):
        kept.add("key", {"rate": 1.0})
    folder = tmp_path / "folder"
    folder.mkdir()
    with pytest.raises(TableError, match=f"^{folder}: is a folder"):
        KeptRows(folder, "code")


@pytest.mark.parametrize("changed", ["setup", "seed", "options", "code", "case"])
def test_kept_rows_of_anything_else_are_not_taken(monkeypatch, cases, tmp_path, changed):
    path = tmp_path / "s.csv.finished"
    interrupted(monkeypatch, cases, path, 4)
    asked = []

    def simulate(case, setup):
        asked.append(case)
        return straight_line(case, setup)

    monkeypatch.setitem(vars(abradem.dem), "simulate", simulate)
    simulate_cases(
        cases.assign(restitution=0.31) if changed == "case" else cases,
        SETUP | {"window": 1.5} if changed == "setup" else SETUP,
        8 if changed == "seed" else 7,
        {"element_size": 0.06} if changed == "options" else None,
        kept=KeptRows(path, "other" if changed == "code" else "code"),
    )
    assert len(asked) == len(cases)


def test_a_larger_sweep_takes_over_what_is_finished(monkeypatch, cases, tmp_path):
    path = tmp_path / "s.csv.finished"
    interrupted(monkeypatch, cases, path, 4)
    monkeypatch.setitem(vars(abradem.dem), "simulate", straight_line)
    more = combinations({**CASE, **SWEPT, "particle_radius": (0.01, 0.02, 0.03)})
    kept = KeptRows(path, "code")
    table = simulate_cases(more, SETUP, 7, kept=kept)
    # Nine cases, of which four were there.
    lines = [line for line in path.read_text().splitlines() if line]
    assert len(lines) == 9
    pd.testing.assert_frame_equal(table, simulate_cases(more, SETUP, 7), check_exact=True)
    kept.remove()
    assert not path.exists()


def test_rows_without_a_rate_are_kept_as_they_are(tmp_path):
    row = {"wear_total_mean": np.nan, "low": 0.1 + 0.2, "status": "rejected: 5 µm", "seed": 2**63}
    path = tmp_path / "new" / "rows"
    with KeptRows(path) as kept:
        kept.add("a", row)
    found = KeptRows(path).find("a")
    assert np.isnan(found.pop("wear_total_mean"))
    assert found == {name: row[name] for name in found} and KeptRows(path).find("b") is None


KILLED = """
import os, time
from abradem.cases import sweep

def told(*_):
    os.write(1, b"%d\\n" % os.getpid())  # in one piece, as both workers write
    time.sleep(600)

sweep._rates = told
if __name__ == "__main__":
    list(sweep._results([(1,), (2,)], 2))
"""


def test_no_process_of_a_killed_sweep_stays(tmp_path):
    script = tmp_path / "killed.py"
    script.write_text(KILLED)
    parent = subprocess.Popen([sys.executable, script], stdout=subprocess.PIPE, text=True)
    workers = [int(parent.stdout.readline()) for _ in range(2)]
    parent.kill()
    parent.wait()
    assert all([has_ended(worker) for worker in workers])


def test_a_surrogate_answers_all_cases(tmp_path, cases):
    jet = Jet(0.25, 9.81, 4.0, None, 0.09, 0.01)
    write_flat_surrogate(tmp_path / "s", jet)
    table, warnings = predict_cases(cases, Surrogate.load(tmp_path / "s"))
    assert warnings == []
    for _, row in table.iterrows():
        rate, low, high = flat_prediction(row, jet)
        assert row["wear_depth_rate"] == pytest.approx(rate, rel=1e-6)
        assert row["wear_depth_rate_lower"] == pytest.approx(low, rel=1e-6)
        assert row["wear_depth_rate_upper"] == pytest.approx(high, rel=1e-6)


# The picture


def drawn(cases, swept, rates):
    rates = np.asarray(rates, dtype=float)
    table = cases.assign(wear_total_mean=rates)
    return sweep_figure(table, swept, "wear_total_mean", 0.9 * rates, 1.2 * rates, "words", "bars")


def curves(figure):
    """x, y and the lower and upper ends of the bars of every curve."""
    found = []
    for container in figure.axes[0].containers:
        line, _, (bars,) = container.lines
        ends = np.array([segment[:, 1] for segment in bars.get_segments()])
        found.append((line.get_xdata(), line.get_ydata(), ends, container.get_label()))
    return found


def test_a_curve_for_each_radius_over_the_angle_in_the_units_of_the_configuration(cases):
    rates = np.array([1.0, 2.0, 3.0, 4.0, 5.0, 6.0]) * 1e-3
    (first, second) = curves(drawn(cases, SWEPT, rates))
    for (x, y, ends, label), expected, radius in ((first, [1, 3, 5], 20), (second, [2, 4, 6], 30)):
        np.testing.assert_allclose(x, [0.0, 30.0, 60.0])
        np.testing.assert_allclose(y, expected)
        np.testing.assert_allclose(ends, np.outer(expected, [0.9, 1.2]))
        assert label == f"$R$ = {radius} mm"


def test_a_radius_along_x_is_in_mm_and_a_single_curve_has_no_legend():
    swept = {"particle_radius": (0.03, 0.01, 0.02)}
    figure = drawn(combinations({**CASE, **swept}), swept, [3.0, 1.0, 2.0])
    ((x, y, _, _),) = curves(figure)
    np.testing.assert_allclose(x, [10.0, 20.0, 30.0])
    np.testing.assert_allclose(y, [1.0, 2.0, 3.0])
    assert "(mm)" in figure.axes[0].get_xlabel() and not figure.legends


def test_a_case_without_a_rate_is_left_out(cases):
    (first, second) = curves(drawn(cases, SWEPT, [1.0, 2.0, np.nan, 4.0, 5.0, np.nan]))
    assert first[0].tolist() == [0.0, 60.0] and second[0].tolist() == [0.0, 30.0]


@pytest.mark.parametrize(("largest", "scale"), [(29.0, "linear"), (31.0, "log")])
def test_decades_are_on_a_logarithmic_axis(cases, largest, scale):
    figure = drawn(cases, SWEPT, [1.0, 2.0, 3.0, 4.0, 5.0, largest])
    assert figure.axes[0].get_yscale() == scale


def test_no_rate_at_all_is_said_in_words(cases):
    figure = drawn(cases, SWEPT, [np.nan] * 6)
    assert [text.get_text() for text in figure.axes[0].texts] == ["no case has a wear rate"]


def test_more_curves_than_can_be_told_apart_are_refused():
    swept = {"plate_angle": range(20), "restitution": tuple(np.linspace(0.2, 0.8, 15))}
    with pytest.raises(ValueError, match=r"15 curves are too many to tell apart \(allowed 14\)"):
        drawn(combinations({**CASE, **swept}), swept, np.ones(300))


def test_curves_are_told_apart_by_colour_and_dashes():
    swept = {"plate_angle": range(14), "restitution": tuple(np.linspace(0.2, 0.8, 14))}
    figure = drawn(combinations({**CASE, **swept}), swept, np.ones(196))
    looks = {
        (container.lines[0].get_color(), container.lines[0].get_linestyle())
        for container in figure.axes[0].containers
    }
    assert len(looks) == 14

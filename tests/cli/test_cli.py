"""Command line: repeating a case, checking a configuration, one line for each error."""

from __future__ import annotations

import subprocess
import sys
import types
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from straight_engine import RATE, straight_line

import abradem
import abradem.dem
from abradem.cli.main import main
from abradem.config import load_config, read_config, sampled_ranges, setup_dict, to_yaml
from abradem.dem.model import Case, Setup
from abradem.running.outputs import record_outputs
from abradem.sampling.draw import block_cases
from abradem.store.tables import read_table, write_table

ROOT = Path(__file__).parents[2]


@pytest.fixture(scope="module")
def config():
    return read_config(ROOT / "config.yaml", ROOT / "studies/smoke.yaml")


@pytest.fixture
def study(tmp_path, config):
    """Return a folder of results as after sampling; case 8 is rejected."""
    folder = tmp_path / "results" / "smoke"
    folder.mkdir(parents=True)
    (folder / "config.yaml").write_text(to_yaml(config))
    size, ranges = config.sampling.cases_per_block, sampled_ranges(config)
    for block in range(config.sampling.blocks):
        cases = block_cases(config.seed, block, size, config.sampling.method, ranges)
        cases.loc[cases["case_id"] == 8, "rejected"] = "too soft for this speed"
        write_table(cases, folder / "cases" / f"block-{block:03d}.parquet")
    return folder


@pytest.fixture
def simulated(monkeypatch):
    """Replace the engine by a straight line and record its arguments."""
    asked = []

    def simulate(case, setup, **_):
        asked.append((case, setup))
        return straight_line(case, setup)

    monkeypatch.setitem(vars(abradem.dem), "simulate", simulate)
    monkeypatch.setattr("abradem.cli.simulate.load_kernels", lambda setup, threads=1: None)
    return asked


def test_the_case_of_the_study_is_simulated(study, simulated, config, capsys):
    assert main(["simulate", "--study", str(study), "--case", "7"]) == 0
    cases = read_table(study / "cases" / "block-001.parquet").set_index("case_id")
    expected = Case.from_row(cases.loc[7])
    assert simulated == [(expected, Setup.from_dict(setup_dict(config)))]
    first, second, third = capsys.readouterr().out.splitlines()
    assert first == "case 7: ok, 3.5 s simulated"
    # The worst of ten rows of a ramp, which is the 99th percentile of a hundred elements too.
    depth_rate = 1e3 * RATE * expected.archard_constant / 0.09 * 10 / 5.5
    assert second.startswith(f"wear depth rate {depth_rate:.6g} mm/s, standard error ")
    assert third.startswith("mean over the plate ")
    assert "worst 30 mm element " in third
    assert third.count(" (standard error ") == 4


@pytest.mark.parametrize(
    ("target", "said"),
    [
        ("wear_friction_p99", "friction, 99th percentile of 60 mm elements"),
        ("wear_sliding_max", "sliding, worst 60 mm element"),
        ("wear_friction_mean", "friction, mean over the plate"),
    ],
)
def test_the_wear_rate_that_is_told_is_the_target_of_the_study(
    study, simulated, config, capsys, target, said
):
    values = config.model_dump(mode="json")
    values["learning"]["target"], values["wear_rate"]["element_size_mm"] = target, 60
    (study / "config.yaml").write_text(to_yaml(load_config(values)))
    assert main(["simulate", "--study", str(study), "--case", "7"]) == 0
    _, second, third = capsys.readouterr().out.splitlines()
    cases = read_table(study / "cases" / "block-001.parquet").set_index("case_id")
    # Of a ramp of 5 rows the last has 9.5 / 5.5 of the mean; it is the 99th percentile as well.
    depth_rate = 1e3 * RATE * cases.loc[7]["archard_constant"] / 0.09
    depth_rate *= 1.0 if target.endswith("mean") else 9.5 / 5.5
    assert second.startswith(f"wear depth rate {depth_rate:.6g} mm/s, standard error ")
    assert f"({said}), quality " in second
    places = ("mean over the plate", "mean over the worn 60 mm elements",
              "mean over the footprint of 60 mm elements", "99th percentile of 60 mm elements",
              "worst 60 mm element")  # fmt: skip
    for place in places:
        assert (place in third) != said.endswith(place)


def test_series_is_written_with_its_units(study, simulated, tmp_path):
    path = tmp_path / "out" / "series.parquet"
    assert main(["simulate", "--study", str(study), "--case", "0", "--series", str(path)]) == 0
    series = read_table(path)
    assert list(series["case_id"].unique()) == [0]
    np.testing.assert_array_equal(series["worn_total"], RATE * series["time"])


@pytest.mark.parametrize(("given", "interval"), [([], 0.01), (["--interval", "0.25"], 0.25)])
def test_snapshots_are_those_of_the_same_case(study, simulated, monkeypatch, given, interval):
    written = []
    module = types.SimpleNamespace(
        write_snapshots=lambda row, *rest: written.append((Case.from_row(row), *rest))
    )
    monkeypatch.setitem(sys.modules, "abradem.simulation.snapshots", module)
    arguments = ["simulate", "--study", str(study), "--case", "3", "--snapshots", "s.parquet"]
    assert main([*arguments, *given]) == 0
    assert written == [(*simulated[0], Path("s.parquet"), interval)]


def test_outputs_that_cannot_be_written_are_named_before_the_simulation(
    study, simulated, tmp_path, capsys
):
    (tmp_path / "file").write_text("")
    (tmp_path / "link").symlink_to("/nonexistent/folder")
    given = ["--series", str(tmp_path / "file" / "s.parquet"), "--snapshots"]
    assert (
        main(["simulate", "--study", str(study), "--case", "3", *given, str(tmp_path / "link")])
        == 2
    )
    assert capsys.readouterr().err.splitlines() == [
        f"{tmp_path / 'file'}: is a file, where a folder must be",
        f"{tmp_path / 'link'}: is a link to /nonexistent/folder, which does not exist",
    ]
    assert simulated == []


def test_rejected_case_says_why_and_is_not_simulated(study, simulated, capsys):
    assert main(["simulate", "--study", str(study), "--case", "8"]) == 1
    assert capsys.readouterr().out == ("case 8: rejected: too soft for this speed, 0 s simulated\n")
    assert simulated == []


def one_line(capsys) -> str:
    captured = capsys.readouterr()
    assert captured.out == ""
    assert captured.err.count("\n") == 1
    return captured.err.strip()


def test_unknown_case_is_one_line(study, simulated, capsys):
    assert main(["simulate", "--study", str(study), "--case", "12"]) == 2
    assert one_line(capsys) == f"{study}/cases: there is no case 12 (allowed 0 ... 11)"


def test_missing_folder_is_one_line(tmp_path, capsys):
    assert main(["simulate", "--study", str(tmp_path / "none"), "--case", "0"]) == 2
    assert one_line(capsys).endswith("there is no such folder; expected one such as results/paper")


def test_folder_without_configuration_is_one_line(tmp_path, capsys):
    assert main(["simulate", "--study", str(tmp_path), "--case", "0"]) == 2
    assert one_line(capsys) == f"{tmp_path}/config.yaml: there is no such file"


def test_folder_without_cases_is_one_line(tmp_path, config, capsys):
    (tmp_path / "config.yaml").write_text(to_yaml(config))
    assert main(["simulate", "--study", str(tmp_path), "--case", "0"]) == 2
    assert "has no block-*.parquet" in one_line(capsys)


def test_corrupt_table_of_cases_is_one_line(study, capsys):
    (study / "cases" / "block-000.parquet").write_bytes(b"PAR1 no more")
    assert main(["simulate", "--study", str(study), "--case", "0"]) == 2
    assert "block-000.parquet: truncated, corrupt or not Parquet" in one_line(capsys)


def test_interval_without_snapshots_is_one_line(study, capsys):
    assert main(["simulate", "--study", str(study), "--case", "0", "--interval", "1"]) == 2
    assert one_line(capsys) == "--interval needs --snapshots FOLDER"


def test_an_error_of_the_program_itself_is_not_hidden(study, monkeypatch):
    def broken(case, setup, **_):
        raise KeyError("a bug")

    monkeypatch.setitem(vars(abradem.dem), "simulate", broken)
    monkeypatch.setattr("abradem.cli.simulate.load_kernels", lambda setup, threads=1: None)
    with pytest.raises(KeyError, match="a bug"):
        main(["simulate", "--study", str(study), "--case", "0"])


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ([], "the following arguments are required: command"),
        (["fly"], "invalid choice: 'fly'"),
        (["simulate", "--study", "x", "--case", "one"], "argument --case: invalid int value"),
        (["simulate", "--study", "x", "--case", "1", "--interval", "-1"],
         "argument --interval: '-1' is not a positive number"),
        (["simulate", "--study", "x", "--case", "1", "--interval", "nan"],
         "argument --interval: 'nan' is not a positive number"),
    ],
)  # fmt: skip
def test_wrong_arguments_are_one_line(arguments, message, capsys):
    with pytest.raises(SystemExit) as error:
        main(arguments)
    assert error.value.code == 2
    assert message in one_line(capsys)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["predict", "--depth", "-5mm"], "--depth -5mm: must be positive"),
        (["predict", "--depth", "-.5"], "--depth -.5: must be positive"),
        (["simulate", "--duration", "-1s"], "--duration -1s: must be positive"),
        (["predict", "-5mm"], "'-5mm' is not of the form NAME=VALUE"),
        (["predict", "--bogus"], "unrecognized arguments: --bogus"),
    ],
)
def test_a_negative_value_with_a_unit_is_a_value(arguments, message, capsys):
    try:
        assert main(arguments) == 2
    except SystemExit as error:
        assert error.code == 2
    assert message in one_line(capsys)


def test_version_is_that_of_the_package(capsys):
    with pytest.raises(SystemExit) as error:
        main(["--version"])
    assert error.value.code == 0
    assert capsys.readouterr().out == f"abradem {abradem.__version__}\n"


def test_a_good_configuration_is_estimated(capsys):
    files = [str(ROOT / "config.yaml"), str(ROOT / "studies/smoke.yaml")]
    assert main(["config", "--check", *files]) == 0
    assert capsys.readouterr().out.startswith("smoke: 12 cases in 2 blocks, ")


def test_folder_of_the_results_is_that_of_the_study(capsys):
    files = [str(ROOT / "config.yaml"), str(ROOT / "studies/smoke.yaml")]
    assert main(["config", "--folder", *files]) == 0
    assert capsys.readouterr().out == "results/smoke\n"


def test_a_bad_configuration_is_one_line_per_problem(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    Path("config.yaml").write_text("study: a b\nseed: -1\n")
    assert main(["config", "--check", "config.yaml"]) == 2
    lines = capsys.readouterr().err.splitlines()
    assert [line.split(":")[1] for line in lines] == [" study", " seed"]


def test_the_command_is_light_until_it_works():
    heavy = ["numba", "torch", "sklearn", "matplotlib", "pandas", "scipy", "snakemake"]
    code = (
        "import sys, abradem.cli.main, abradem.config\n"
        f"print([name for name in {heavy} if name in sys.modules])"
    )
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert run.stdout.strip() == "[]"


def test_cases_of_a_study_survive_their_file_bit_for_bit(study, config):
    ranges = sampled_ranges(config)
    drawn = block_cases(config.seed, 0, config.sampling.cases_per_block, "lhs", ranges)
    pd.testing.assert_frame_equal(
        read_table(study / "cases" / "block-000.parquet"), drawn, check_exact=True
    )


# Damage


@pytest.mark.parametrize("name", ["config.yaml", "cases/block-000.parquet"])
def test_a_case_is_not_repeated_from_a_damaged_file(study, simulated, capsys, name):
    """A digit of the configuration that was changed would give another wear rate."""
    record_outputs(study, "all", [study / name])
    assert main(["simulate", "--study", str(study), "--case", "1"]) in (0, 1)
    assert len(simulated) == 1
    capsys.readouterr()
    content = bytearray((study / name).read_bytes())
    content[len(content) // 2] ^= 1
    (study / name).write_bytes(content)
    assert main(["simulate", "--study", str(study), "--case", "1"]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith(f"{study / name}: damaged, differs from what its job wrote; `abradem")
    assert len(simulated) == 1


@pytest.mark.parametrize("error", [MemoryError(), OSError(12, "Cannot allocate memory")])
def test_a_command_without_memory_ends_in_one_line(study, monkeypatch, capsys, error):
    def simulate(*_, **__):
        raise error

    monkeypatch.setattr("abradem.dem.simulate", simulate)
    monkeypatch.setattr("abradem.cli.simulate.load_kernels", lambda setup, threads=1: None)
    assert main(["simulate", "--study", str(study), "--case", "1"]) == 3
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith("there was too little memory")

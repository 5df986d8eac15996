"""The command line: predict a wear rate, repeat a case, check a configuration or the results.

Invalid input ends with one line for each problem on stderr and exit code 2, too little memory with
one line and exit code 3. What needs numpy is imported when the command is known, as the import
fails without memory.
"""

from __future__ import annotations

import argparse
import math
import re
import sys
from collections.abc import Sequence
from pathlib import Path

import abradem
from abradem.cli.arguments import joined
from abradem.store.errors import memory_problem, too_small_limit

DESCRIPTION = "Wear data sets, models and figures from ranges of materials and geometry."
"""Not from a docstring, as Python has none with PYTHONOPTIMIZE=2."""

WRONG_INPUT = 2
"""Exit code for invalid input."""

NOT_OK = 1
"""Exit code for a case that was simulated but did not complete normally."""


NO_MEMORY = 3
"""Exit code for too little memory."""

LEAST_MEMORY = {"simulate": 1000, "predict": 160, "config": 500, "doctor": 500}
"""Address space, MB, below which a command cannot load the libraries that it needs."""


class InputError(ValueError):
    """Invalid input; the message is one line for each problem."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line and return the exit code."""
    arguments = sys.argv[1:] if arguments is None else list(arguments)
    command = arguments[0] if arguments and arguments[0] in LEAST_MEMORY else "predict"
    if line := too_small_limit(f"abradem {command}", LEAST_MEMORY[command]):
        print(line, file=sys.stderr)
        return NO_MEMORY
    try:
        from abradem.running.environment import force_environment

        # Before help is printed, which has characters that an encoding may lack.
        force_environment()
        options = _parser().parse_args(joined(arguments))
        return options.run(options)
    except Exception as error:
        if line := memory_problem(error):
            print(line, file=sys.stderr)
            return NO_MEMORY
        if not _is_of_the_user(error):
            raise
        print(error, file=sys.stderr)
        return WRONG_INPUT


def _is_of_the_user(error: Exception) -> bool:
    """Whether an error is due to the user's input or the file system, and not a bug."""
    explained = {"InputError", "ConfigError", "TableError", "PredictionError"}
    names = {kind.__name__ for kind in type(error).__mro__}
    return isinstance(error, OSError) or bool(names & explained)


class _Parser(argparse.ArgumentParser):
    def error(self, message: str):
        # One line without the usage, which --help prints.
        self.exit(WRONG_INPUT, f"{self.prog}: {message} (see {self.prog} --help)\n")


def _parser() -> argparse.ArgumentParser:
    from abradem.cli.doctor import add_doctor
    from abradem.cli.predict import add_parser as add_predict

    parser = _Parser(prog="abradem", description=DESCRIPTION)
    parser.add_argument("--version", action="version", version=f"abradem {abradem.__version__}")
    commands = parser.add_subparsers(dest="command", required=True, metavar="command")

    simulate = commands.add_parser(
        "simulate",
        help="repeat the simulation of one case of a study, bit for bit",
        description="Repeat the simulation of one case of a study, bit for bit.",
    )
    simulate.add_argument(
        "--study", required=True, type=Path, metavar="FOLDER",
        help="results of the study, such as results/paper",
    )  # fmt: skip
    simulate.add_argument("--case", required=True, type=int, metavar="N", help="number of the case")
    simulate.add_argument(
        "--series", type=Path, metavar="FILE", help="write the worn volume over time (Parquet)"
    )
    simulate.add_argument(
        "--snapshots",
        type=Path,
        metavar="FOLDER",
        help="write particles, contacts and wear at intervals (three Parquet files)",
    )
    simulate.add_argument(
        "--interval",
        type=_positive,
        metavar="S",
        help="simulated seconds between snapshots; default: that of the study",
    )
    simulate.set_defaults(run=_simulate)

    add_predict(commands)

    config = commands.add_parser(
        "config",
        help="check a configuration and print what it would run",
        description="Check a configuration and print what it would run.",
    )
    what = config.add_mutually_exclusive_group(required=True)
    what.add_argument(
        "--check",
        nargs="+",
        type=Path,
        metavar="FILE",
        help="files; later files override earlier ones: config.yaml studies/smoke.yaml",
    )
    what.add_argument(
        "--folder",
        nargs="+",
        type=Path,
        metavar="FILE",
        help="check the files and print the folder of the results instead",
    )
    config.set_defaults(run=_check_config)

    add_doctor(commands)
    return parser


def _positive(text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not (value > 0.0 and math.isfinite(value)):
        raise argparse.ArgumentTypeError(f"{text!r} is not a positive number")
    return value


def _check_config(options: argparse.Namespace) -> int:
    from abradem.config import read_config
    from abradem.running.effort import estimate

    files = options.check or options.folder
    config = read_config(*files)
    if config.calibration.table is not None:
        from abradem.running.given_tables import calibration_inputs

        calibration_inputs(config, files)
    elif config.dataset.external is not None:
        from abradem.running.given_tables import external_input

        found = external_input(config)
        if found.nothing_varies:
            raise InputError(found.nothing_varies)
        if found.repeated:
            print(f"{config.dataset.external}: {found.repeated}", file=sys.stderr)
    print(estimate(config) if options.check else f"results/{config.study}")
    return 0


def _simulate(options: argparse.Namespace) -> int:
    from abradem.config import rate_options, read_config, setup_dict, target_dict
    from abradem.simulation.batch import run_case
    from abradem.store.files import why_not_written

    if options.interval is not None and options.snapshots is None:
        raise InputError("--interval needs --snapshots FOLDER")
    config = read_config(_undamaged(_existing(options.study) / "config.yaml"))
    setup = setup_dict(config)
    row = find_case(options.study, options.case)
    # Before minutes of simulation.
    folders = [options.series and options.series.parent, options.snapshots]
    if problems := [why for folder in folders if folder and (why := why_not_written(folder))]:
        raise InputError("\n".join(problems))

    tables = run_case(row, setup)
    if options.series:
        from abradem.store.tables import write_table

        write_table(tables["series"], options.series)
    if options.snapshots and not row["rejected"]:
        from abradem.dem.model import Case, Setup
        from abradem.simulation.snapshots import write_snapshots

        interval = options.interval or config.simulation.export.interval_s
        write_snapshots(Case.from_row(row), Setup.from_dict(setup), options.snapshots, interval)

    run = tables["runs"].iloc[0]
    print(f"case {options.case}: {run['status']}, {run['simulated_time']:g} s simulated")
    if run["status"] != "ok":
        return NOT_OK
    print(_wear_line(tables, row, setup, rate_options(config), target_dict(config)))
    return 0


def find_case(study: Path, case: int) -> dict:
    """Find the row of a case in ``cases/block-*.parquet`` of the results of a study.

    Parameters
    ----------
    study : path
        Folder of the results.
    case : int
        Number of the case.

    Returns
    -------
    dict
        The row by column name.

    Raises
    ------
    InputError
        If there are no cases, or not this one.
    """
    from abradem.store.tables import read_table

    folder = study / "cases"
    files = {
        int(found.group(1)): path
        for path in folder.glob("block-*.parquet")
        if (found := re.fullmatch(r"block-(\d+)\.parquet", path.name))
    }
    if not files:
        raise InputError(f"{folder}: has no block-*.parquet; run the sampling of the study first")
    most = -1
    for _, path in sorted(files.items()):
        cases = read_table(_undamaged(path))
        rows = cases[cases["case_id"] == case]
        if len(rows):
            return rows.iloc[0].to_dict()
        most = max(most, int(cases["case_id"].max()))
    raise InputError(f"{folder}: there is no case {case} (allowed 0 ... {most})")


def _undamaged(path: Path) -> Path:
    """Return the path of a result; raises if its content differs from what its job wrote."""
    from abradem.store.checksums import damage

    if path.exists() and (line := damage(path)):
        raise InputError(line)
    return path


def _existing(folder: Path) -> Path:
    if not folder.is_dir():
        raise InputError(f"{folder}: there is no such folder; expected one such as results/paper")
    return folder


def _wear_line(tables: dict, row: dict, setup: dict, options: dict, target: dict) -> str:
    """Two lines with the wear rates of a case: the study's target, and its other statistics."""
    import pandas as pd

    from abradem.dem.model import Setup
    from abradem.quantities import STATISTICS, stderr_column, wear_column
    from abradem.simulation.batch import TABLES
    from abradem.wear.rates import wear_rates
    from abradem.words.wear import WearTarget

    rates = wear_rates(
        **{name: tables[name] for name in TABLES},
        cases=pd.DataFrame([row]),
        setup=Setup.from_dict(setup),
        **options,
    ).iloc[0]
    said = WearTarget(**target)
    others = (
        said._replace(name=wear_column(said.measure, statistic))
        for statistic in STATISTICS
        if statistic != said.statistic
    )
    places = ", ".join(
        f"{one.place} {rates[one.name]:.4g} (standard error "
        f"{rates[stderr_column(one.name)]:.2g}) mm/s"
        for one in others
    )
    return (
        f"wear depth rate {rates[said.name]:.6g} mm/s, standard error "
        f"{rates[stderr_column(said.name)]:.2g} mm/s ({said.measure}, {said.place}), quality "
        f"{rates['quality']}\n{places}"
    )


if __name__ == "__main__":
    sys.exit(main())

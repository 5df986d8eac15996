"""The command `abradem simulate`: a case of one's own, or a case of a study again."""

from __future__ import annotations

import argparse
import math
import re
import sys
from pathlib import Path

from abradem.cli.arguments import InputError
from abradem.cli.case_input import (
    add_case_arguments,
    headline,
    load_kernels,
    middle_of_ranges,
    own_geometry,
    patch_words,
    progress_line,
    read_setup,
    say_origins,
    surface_words,
    unused_values,
    with_given_numbers,
)
from abradem.cli.given_values import Given, given_values, impossible_values
from abradem.surrogate.model import PredictionError
from abradem.words.wear import WearTarget

NOT_OK = 1
"""Exit code for a case that was simulated but gave no wear rate."""

TABLE_SUFFIXES = (".parquet", ".csv")
PICTURE_SUFFIXES = (".png", ".pdf", ".svg")
SCENE_SUFFIXES = (".vtp",)

_OF_OWN_CASE = ("material", "config", "geometry", "unit", "duration", "seed", "model")

EPILOG = """\
examples:
  abradem simulate plate_angle=45deg particle_radius=20mm --material granite
  abradem simulate plate_angle=20deg --set factory.mass_rate_kg_s=10 --map map.png
  abradem simulate --geometry chute.stl particle_radius=20mm --map map.png --map cells.csv
  abradem simulate --study results/paper --case 42 --series case-42.parquet

`abradem predict --help` lists the quantities, their units and the materials, docs/config.md the
keys of --set. A quantity that is not given is in the middle of its range in the configuration.
"""


def add_simulate(commands) -> None:
    """Add the command to the subparsers of the command line."""
    parser = commands.add_parser(
        "simulate",
        help="simulate a case of your own, or a case of a study again, bit for bit",
        description="Simulate a case of your own, or a case of a study again, bit for bit.",
        epilog=EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument(
        "values", nargs="*", metavar="NAME=VALUE", help="such as particle_radius=20mm"
    )
    add_case_arguments(parser)
    parser.add_argument(
        "--study", type=Path, metavar="FOLDER",
        help="repeat a case of this study, such as results/paper",
    )  # fmt: skip
    parser.add_argument("--case", type=int, metavar="N", help="number of the case of the study")
    parser.add_argument(
        "--map",
        type=Path,
        action="append",
        default=[],
        metavar="FILE",
        help="write the wear depth rate of every facet: .parquet or .csv, a picture, .png, .pdf "
        "or .svg, or for a geometry .vtp for ParaView; may be given several times",
    )
    parser.add_argument(
        "--series",
        type=Path,
        metavar="FILE",
        help="write the worn volume over time: .parquet or .csv, or a picture of the wear depth",
    )
    parser.add_argument(
        "--snapshots",
        type=Path,
        metavar="FOLDER",
        help="write particles, contacts and wear at intervals (three Parquet files)",
    )
    parser.add_argument(
        "--interval",
        type=_positive,
        metavar="S",
        help="simulated seconds between snapshots; default: that of the study",
    )
    parser.add_argument(
        "--threads",
        type=_threads,
        metavar="N",
        help="threads that share a crowd of particles, 1 to 64; the result does not depend on "
        "them; default: simulation.threads of the configuration",
    )
    parser.set_defaults(run=run_simulate)


def _positive(text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not (value > 0.0 and math.isfinite(value)):
        raise argparse.ArgumentTypeError(f"{text!r} is not a positive number")
    return value


def _threads(text: str) -> int:
    from abradem.dem.model import MOST_THREADS

    try:
        number = int(text)
    except ValueError:
        number = 0
    if not 1 <= number <= MOST_THREADS:
        raise argparse.ArgumentTypeError(
            f"{text!r} is not a number of threads (allowed 1 ... {MOST_THREADS})"
        )
    return number


def run_simulate(options: argparse.Namespace) -> int:
    """Run the command and return the exit code."""
    problems = _output_problems(options)
    if options.study is None:
        if options.case is not None:
            problems.append("--case needs --study FOLDER")
        return _own_case(options, problems)
    foreign = [f"--{name}" for name in _OF_OWN_CASE if getattr(options, name) is not None]
    foreign += ["--set"] if options.set else []
    foreign += ["NAME=VALUE"] if options.values else []
    if foreign:
        problems.append(f"--study repeats a case as it is, without {', '.join(foreign)}")
    if options.case is None:
        problems.append("--study needs --case N")
    if problems:
        raise InputError("\n".join(problems))
    return _case_of_study(options)


def _output_problems(options: argparse.Namespace) -> list[str]:
    """Return what is wrong with the outputs; asked before minutes of simulation."""
    from abradem.store.files import why_not_written

    problems = []
    if options.interval is not None and options.snapshots is None:
        problems.append("--interval needs --snapshots FOLDER")
    named = [("map", path) for path in options.map]
    named += [("series", options.series)] if options.series else []
    for name, path in named:
        allowed = (*TABLE_SUFFIXES, *PICTURE_SUFFIXES, *(SCENE_SUFFIXES if name == "map" else ()))
        if path.suffix.lower() not in allowed:
            problems.append(f"--{name} {path}: must end with one of {', '.join(allowed)}")
        elif path.is_dir():
            problems.append(f"--{name} {path}: is a folder; name a file")
    folders = [path.parent for _, path in named]
    folders += [options.snapshots] if options.snapshots else []
    problems += dict.fromkeys(why for folder in folders if (why := why_not_written(folder)))
    return problems


def _scene_problems(options: argparse.Namespace, setup: dict) -> list[str]:
    """Return a line for each file for ParaView that is asked for without a geometry."""
    if setup.get("geometry"):
        return []
    return [
        f"--map {path}: the plate is shown by snakemake vtk (allowed with a geometry)"
        for path in options.map
        if path.suffix.lower() in SCENE_SUFFIXES
    ]


def _own_case(options: argparse.Namespace, problems: list[str]) -> int:
    """Simulate the case that the options describe."""
    given = Given({}, {})
    of_setup: list[str] = []
    own = read_setup(options, of_setup)
    try:
        given = given_values(options.values, options.material, own_geometry(own))
    except PredictionError as error:
        problems += str(error).splitlines()
    problems += of_setup
    problems += impossible_values(given.values)
    problems += unused_values(own, given.values)
    problems += _scene_problems(options, own.setup) if own is not None else []
    if problems or own is None:
        raise InputError("\n".join(problems))

    from abradem.cli.surrogate_beside import surrogate_beside
    from abradem.dem.model import Setup
    from abradem.sampling.checks import check_case

    own = with_given_numbers(own, given.values)
    filled = middle_of_ranges(own, given.values)
    values = {**given.values, **filled}
    try:
        reason = check_case(values, Setup.from_dict(own.setup))
    except ValueError as error:
        reason = str(error)
    if reason:
        raise InputError(f"this case cannot be simulated: {reason}")
    surrogate = surrogate_beside(options.model, own, values)
    say_origins(given, own, filled)
    row = {"case_id": 0, "block": 0, "seed": own.seed, "rejected": "", **values}
    rates = _simulated(row, own.setup, own.config, options, "")
    if rates is None:
        return NOT_OK
    if surrogate is not None:
        surrogate.say(values, rates)
    return 0


def _case_of_study(options: argparse.Namespace) -> int:
    """Simulate a case of a study again."""
    from abradem.config import read_config, setup_dict

    config = read_config(_undamaged(_existing(options.study) / "config.yaml"))
    setup = setup_dict(config)
    if problems := _scene_problems(options, setup):
        raise InputError("\n".join(problems))
    row = find_case(options.study, options.case)
    rates = _simulated(row, setup, config, options, f"case {options.case}: ")
    return NOT_OK if rates is None else 0


def _simulated(row: dict, setup: dict, config, options: argparse.Namespace, name: str):
    """Simulate a case, write and print its results; return its wear rates or None."""
    import pandas as pd

    from abradem.config import rate_options
    from abradem.dem.model import Setup
    from abradem.simulation.batch import TABLES, run_case
    from abradem.wear.rates import wear_rates

    progress, clear = None, lambda: None
    threads = options.threads or config.threads
    if not row["rejected"]:
        if setup.get("geometry"):
            from abradem.geometry.build import case_surface, factory_of

            described = Setup.from_dict(setup)
            try:
                surface, factory = case_surface(described, row), factory_of(described, row)
            except ValueError as error:
                raise InputError(f"this case cannot be simulated: {error}") from None
            print(surface_words(surface), file=sys.stderr)
            print(patch_words(factory), file=sys.stderr)
        load_kernels(setup, threads)
        progress, clear = progress_line(setup)
    try:
        tables = run_case(row, setup, progress, threads)
    finally:
        clear()
    cases = pd.DataFrame([row])
    _write_outputs(tables, row, setup, config, options)
    run = tables["runs"].iloc[0]
    print(f"{name}{run['status']}, {run['simulated_time']:g} s simulated")
    if run["status"] != "ok":
        return None
    rates = wear_rates(
        **{table: tables[table] for table in TABLES},
        cases=cases,
        setup=Setup.from_dict(setup),
        **rate_options(config),
    ).iloc[0]
    if not math.isfinite(run["steady_from"]):
        worn = "surface" if setup.get("geometry") else "plate"
        print(
            f"no wear rate: the {worn} did not wear steadily for the window of "
            f"{setup['window']:g} s; simulate longer, or shorten simulation.stop.window_s",
            file=sys.stderr,
        )
        return None
    print(wear_lines(rates, headline(config)))
    return rates


def wear_lines(rates, target: WearTarget) -> str:
    """Return the wear rates of a case in two lines: the target, and its other statistics.

    Parameters
    ----------
    rates : pandas.Series
        Row of `abradem.wear.rates.wear_rates`.
    target : WearTarget
    """
    from abradem.quantities import STATISTICS, stderr_column, wear_column

    others = (
        target._replace(name=wear_column(target.measure, statistic))
        for statistic in STATISTICS
        if statistic != target.statistic
    )
    places = ", ".join(
        f"{one.place} {rates[one.name]:.4g} (standard error "
        f"{rates[stderr_column(one.name)]:.2g}) mm/s"
        for one in others
    )
    return (
        f"wear depth rate {rates[target.name]:.6g} mm/s, standard error "
        f"{rates[stderr_column(target.name)]:.2g} mm/s ({target.measure}, {target.place}), quality "
        f"{rates['quality']}\n{places}"
    )


def _write_outputs(tables: dict, row: dict, setup: dict, config, options) -> None:
    from abradem.cli.case_files import write_map, write_series, write_surface_map

    target = headline(config)
    numbered = options.study is not None
    steady = tables["runs"]["window_end"].notna().all()
    if options.series:
        write_series(tables, row, setup, target, options.series, numbered)
    for path in options.map:
        if not steady:
            print(f"--map {path}: not written, no complete window", file=sys.stderr)
        elif setup.get("geometry"):
            write_surface_map(tables, row, setup, target, path)
        else:
            write_map(tables, row, setup, target, path, numbered)
    if options.snapshots and not row["rejected"]:
        from abradem.dem.model import Setup
        from abradem.simulation.snapshots import write_snapshots

        interval = options.interval or config.simulation.export.interval_s
        write_snapshots(row, Setup.from_dict(setup), options.snapshots, interval)


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

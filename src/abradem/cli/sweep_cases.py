"""The command `abradem sweep`: wear rates of all combinations of some values."""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from abradem.cli.arguments import InputError
from abradem.cli.case_input import (
    OwnSetup,
    add_case_arguments,
    check_mesh,
    headline,
    load_kernels,
    middle_of_ranges,
    own_geometry,
    read_setup,
    say_origins,
    unused_values,
    with_given_numbers,
)
from abradem.cli.given_values import (
    Given,
    Swept,
    confidence_level,
    impossible_values,
    swept_values,
)
from abradem.surrogate.model import PredictionError, Surrogate

if TYPE_CHECKING:
    from abradem.cases.kept_rows import KeptRows

NOT_ALL_OK = 1
"""Exit code if a case of the sweep has no wear rate."""

EPILOG = """\
A value, a list or a range FIRST:LAST:STEP; a unit behind the last number is that of all:
  abradem sweep plate_angle=0:70:5deg particle_radius=10,20mm --figure sweep.png
  abradem sweep plate_angle=0:70:1 --surrogate --output sweep.csv

`abradem predict --help` lists the quantities, their units and the materials. A quantity that is
not given is in the middle of its range in the configuration. All cases have the same seed.
Finished cases of an interrupted sweep are in OUTPUT.finished: the same command goes on.
"""


def add_sweep(commands) -> None:
    """Add the command to the subparsers of the command line."""
    parser = commands.add_parser(
        "sweep",
        help="wear rates of all combinations of some values, as a table and a picture",
        description="Simulate, or predict, the wear rates of all combinations of some values.",
        epilog=EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument(
        "values", nargs="+", metavar="NAME=VALUES", help="such as plate_angle=0:70:5"
    )
    add_case_arguments(parser)
    parser.add_argument(
        "--surrogate", action="store_true", help="predict with the surrogate, simulate nothing"
    )
    parser.add_argument(
        "--confidence", metavar="P", help="level of the intervals of the surrogate, such as 0.9"
    )
    parser.add_argument(
        "--cores",
        type=int,
        metavar="N",
        default=len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else 1,
        help="cases simulated at a time; default: the cores of this machine",
    )
    parser.add_argument(
        "--output",
        type=Path,
        metavar="FILE",
        help="write the table, .csv or .parquet; default: print it as CSV",
    )
    parser.add_argument(
        "--figure", type=Path, metavar="FILE", help="draw the rates, .png, .pdf or .svg"
    )
    parser.set_defaults(run=run_sweep)


def run_sweep(options: argparse.Namespace) -> int:
    """Run the command and return the exit code."""
    problems = _option_problems(options)
    swept = Swept(Given({}, {}), {})
    level = None
    of_setup: list[str] = []
    own = read_setup(options, of_setup)
    try:
        swept = swept_values(options.values, options.material, own_geometry(own))
    except PredictionError as error:
        problems += str(error).splitlines()
    try:
        level = None if options.confidence is None else confidence_level(options.confidence)
    except PredictionError as error:
        problems.append(str(error))
    problems += of_setup
    problems += impossible_values({**swept.fixed.values, **swept.lists})
    problems += unused_values(own, {**swept.fixed.values, **swept.lists})
    problems += _figure_problems(options, swept)
    if problems or own is None:
        raise InputError("\n".join(problems))

    from abradem.cases.sweep import combinations

    own = with_given_numbers(own, [*swept.fixed.values, *swept.lists])
    filled = middle_of_ranges(own, {**swept.fixed.values, **swept.lists})
    values: dict[str, float | Sequence[float]] = {**swept.lists, **swept.fixed.values, **filled}
    try:
        cases = combinations(values)
    except ValueError as error:
        raise InputError(str(error)) from None
    check_mesh(own.setup)
    if options.surrogate:
        return _predict(cases, swept, own, filled, level, options)
    return _simulate(cases, swept, own, filled, options)


def _option_problems(options: argparse.Namespace) -> list[str]:
    from abradem.store.files import why_not_written

    problems = []
    for name, allowed in (("output", (".csv", ".parquet")), ("figure", (".png", ".pdf", ".svg"))):
        path = getattr(options, name)
        if path is None:
            continue
        if path.suffix.lower() not in allowed:
            problems.append(f"--{name} {path}: must end with one of {', '.join(allowed)}")
        elif path.is_dir():
            problems.append(f"--{name} {path}: is a folder; name a file")
        elif why := why_not_written(path.parent):
            problems.append(why)
    if options.cores < 1:
        problems.append(f"--cores {options.cores}: must be at least 1")
    if options.surrogate:
        of_engine = {"duration": options.duration, "seed": options.seed}
        problems += [
            f"--{name} is for simulations, without --surrogate"
            for name, value in of_engine.items()
            if value is not None
        ]
    else:
        of_surrogate = {"model": options.model, "confidence": options.confidence}
        problems += [
            f"--{name} needs --surrogate"
            for name, value in of_surrogate.items()
            if value is not None
        ]
    return list(dict.fromkeys(problems))


def _figure_problems(options: argparse.Namespace, swept: Swept) -> list[str]:
    if options.figure is None:
        return []
    if not swept.lists:
        return ["--figure needs a quantity with several values"]
    from abradem.figures.sweep import MOST_CURVES, curve_count

    curves = curve_count(swept.lists)
    if curves > MOST_CURVES:
        return [f"--figure: {curves} curves are too many to tell apart (allowed {MOST_CURVES})"]
    return []


def _simulate(cases, swept: Swept, own: OwnSetup, filled: dict, options) -> int:
    from abradem.cases.sweep import simulate_cases
    from abradem.config import rate_options
    from abradem.quantities import stderr_column

    say_origins(swept.fixed, own, filled)
    load_kernels(own.setup)
    kept = _kept_rows(own, options)
    table = simulate_cases(
        cases, own.setup, own.seed, rate_options(own.config), options.cores, _counter(len(cases)),
        kept,
    )  # fmt: skip
    said = headline(own.config)
    target = said.name
    rate, error = table[target].to_numpy(), table[stderr_column(target)].to_numpy()
    _write(table, options)
    if options.figure:
        bars = "bars: standard error"
        words = f"{said.words[0].upper()}{said.words[1:]}"
        _draw(table, swept, target, rate - error, rate + error, words, bars, options.figure)
    lacking = table[table[target].isna()]
    kept.remove()
    _say(len(table), len(lacking), "simulated", options)
    for _, row in lacking.iterrows():
        named = ", ".join(f"{name} = {row[name]:g}" for name in swept.lists)
        why = row["quality"] if row["status"] == "ok" else row["status"]
        print(f"no wear rate: {named or 'the case'}: {why}", file=sys.stderr)
    return NOT_ALL_OK if len(lacking) else 0


def _kept_rows(own: OwnSetup, options: argparse.Namespace) -> KeptRows:
    """Finished cases of this sweep: beside its table, or beside its picture without a table."""
    from abradem.cases import kept_rows, sweep
    from abradem.geometry.build import mesh_file
    from abradem.running.code_hash import files_hash, step_hash

    beside = options.output or options.figure
    if beside is None:
        return kept_rows.KeptRows()
    geometry = own.setup.get("geometry")
    mesh = None if geometry is None else mesh_file(geometry)
    code = step_hash(Path(sweep.__file__))
    content = files_hash(Path(mesh)) if mesh else ""
    return kept_rows.KeptRows(beside.with_name(f"{beside.name}.finished"), f"{code} {content}")


def _predict(cases, swept: Swept, own: OwnSetup, filled: dict, level, options) -> int:
    from abradem.cases.sweep import predict_cases
    from abradem.cli.predict_words import place_words, warn
    from abradem.cli.surrogate_beside import check_geometry

    stem = options.model or f"results/{own.config.study}/models/surrogate"
    surrogate = Surrogate.load(stem)
    check_geometry(surrogate, stem, own, cases)
    say_origins(swept.fixed, own, filled)
    table, warnings = predict_cases(cases, surrogate, level)
    warn(warnings)
    _write(table, options)
    if options.figure:
        name = surrogate.description["target"]["name"]
        shown = level or min(surrogate.usual_confidence, surrogate.highest_confidence)
        low, high = (table[f"wear_depth_rate_{end}"].to_numpy() for end in ("lower", "upper"))
        words = f"Surrogate, {name}: {place_words(surrogate)}"
        bars = f"bars: {100.0 * shown:.4g} % interval"
        _draw(table, swept, "wear_depth_rate", low, high, words, bars, options.figure)
    _say(len(table), 0, "predicted", options)
    return 0


def _write(table, options: argparse.Namespace) -> None:
    from abradem.cli.case_files import unit_headers, write_with_units
    from abradem.store.columns import PREDICTED

    if options.output is None:
        print(table.rename(columns=unit_headers(table, PREDICTED)).to_csv(index=False), end="")
    else:
        write_with_units(table, options.output, PREDICTED)


def _draw(table, swept: Swept, rate: str, low, high, words: str, bars: str, path: Path) -> None:
    from abradem.figures.style import save
    from abradem.figures.sweep import sweep_figure

    figure = sweep_figure(table, swept.lists, rate, low, high, words, bars)
    save(figure, path.with_suffix(""), [path.suffix.lower().removeprefix(".")])


def _say(count: int, lacking: int, what: str, options: argparse.Namespace) -> None:
    written = [str(path) for path in (options.output, options.figure) if path]
    where = f", written to {' and '.join(written)}" if written else ""
    without = f", {lacking} without a wear rate" if lacking else ""
    print(
        f"{count} case{'' if count == 1 else 's'} {what}{without}{where}",
        file=sys.stdout if options.output else sys.stderr,
    )


def _counter(count: int):
    """Return what shows the number of finished cases on a terminal, or None."""
    if not sys.stderr.isatty():
        return None
    from abradem.running.job_log import CLEAR

    def finished(done: int) -> None:
        text = "" if done == count else f"{done} of {count} cases simulated"
        print(f"{CLEAR}{text}", end="", file=sys.stderr, flush=True)

    return finished

"""The command `abradem predict`: wear depth rate and service life of single cases or of a table.

Single cases need only numpy and safetensors; pandas and pyarrow are imported for tables.
"""

from __future__ import annotations

import argparse
import re
from pathlib import Path

from abradem.cli.given_values import (
    Given,
    add_material_argument,
    confidence_level,
    depth_mm,
    given_values,
    hours_of,
    say_preset,
)
from abradem.cli.inverse_questions import Depth, print_extremes, print_solution, target_of
from abradem.cli.predict_map import check_map_path, predict_map
from abradem.cli.predict_words import NO_END, depth_words, fixed_words, rate_text, warn
from abradem.config.materials import PARTICLE_MATERIALS, PLATE_MATERIALS
from abradem.learning.number_text import number_or_words
from abradem.quantities import SAMPLED
from abradem.surrogate.model import PredictionError, Surrogate
from abradem.words.labels import LABELS

EPILOG = """\
quantities (unit, range of the paper, meaning):
{quantities}

A geometry with sampled quantities has these as well, such as arc.radius=400mm or, for the plate
that is named lower, lower.angle=150deg.

A value may have a unit: 20mm, 45°, -5 m/s, 18 km/h, 2.65 g/cm³. Otherwise the unit is that above.

archard_constant is W of Archard's law h = W F_n s / A: W = k / H, with the dimensionless wear
coefficient k and the hardness H of the plate (k = 1e-4 and H = 2 GPa give 5e-14 1/Pa). It is the
same as the specific wear rate that tests of wear report: 1 mm³/(N m) = 1e-9 1/Pa.

materials:
{materials}

example:
  abradem predict --material granite plate_angle=45deg factory_angle=0deg \\
    particle_radius=20mm particle_velocity_y=-5m/s archard_constant=1e-9/Pa
"""


def add_parser(commands) -> None:
    """Add the command to the subparsers of the command line."""
    epilog = EPILOG.format(quantities=_quantities(), materials=_materials())
    parser = commands.add_parser(
        "predict",
        help="predict the wear depth rate of a plate, with an interval",
        description="Predict the wear depth rate of a plate with the surrogate of a study.",
        epilog=epilog,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument(
        "values", nargs="*", metavar="NAME=VALUE", help="such as particle_radius=20mm"
    )
    add_material_argument(parser)
    parser.add_argument(
        "--model",
        metavar="STEM",
        help="surrogate files without suffix; default: results/<study>/models/surrogate with the "
        "study of ./config.yaml",
    )
    parser.add_argument(
        "--confidence",
        metavar="P",
        help="level of the interval, such as 0.9 or 90; default: 0.95, or the highest that the "
        "surrogate can promise",
    )
    parser.add_argument(
        "--depth",
        metavar="VALUE",
        help="also print the hours until this wear depth, such as 5mm, of every place of the plate "
        "that the surrogate predicts",
    )
    parser.add_argument(
        "--hours", metavar="VALUE", help="for --solve: after these hours, such as 1000 or 60000min"
    )
    parser.add_argument(
        "--solve",
        metavar="NAME[=FROM:TO]",
        help="the values of a quantity with which --depth is worn in --hours, in its training "
        "range or in the one given; archard_constant in closed form, others all that there are",
    )
    parser.add_argument(
        "--extremes",
        metavar="NAME[=FROM:TO]",
        help="the least and the greatest wear over the range of a quantity, such as "
        "plate_angle=20:60deg",
    )
    parser.add_argument(
        "--target",
        metavar="NAME",
        help="place of the plate for --solve and --extremes: mean, footprint, p99 or max (the "
        "worst element), as far as the surrogate holds it; default: the target of its study",
    )
    parser.add_argument(
        "--table", metavar="FILE",
        help="predict many cases: .csv or .parquet with the quantities as columns; missing columns "
        "are taken from NAME=VALUE and --material",
    )  # fmt: skip
    parser.add_argument(
        "--output",
        metavar="FILE",
        help="write the table with predictions, .csv or .parquet; default: print it as CSV",
    )
    parser.add_argument(
        "--map",
        type=Path,
        metavar="FILE",
        help="also write the predicted wear map of the plate: .png, .pdf, .svg, .parquet or .csv",
    )
    parser.add_argument(
        "--onnx", type=Path, metavar="FILE", help="write the surrogate as ONNX (extra: onnx)"
    )
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Run the command and return the exit code."""
    if options.output is not None and options.table is None:
        raise PredictionError("--output needs --table FILE")
    _refuse_combinations(options)
    if options.map is not None:
        check_map_path(options.map)
    surrogate = _surrogate(options.model)
    geometry = surrogate.jet.geometry if isinstance(surrogate, Surrogate) else None
    given = given_values(options.values, options.material, geometry)
    depth = None if options.depth is None else depth_mm(options.depth)
    level = None if options.confidence is None else confidence_level(options.confidence)
    if not isinstance(surrogate, Surrogate):
        raise surrogate
    fixed = [name for name in given.values if name not in surrogate.ranges]
    if fixed:
        raise PredictionError(fixed_words(surrogate, fixed))
    if options.map is not None and geometry is not None:
        raise PredictionError(
            f"--map {options.map}: the map of a geometry is not predicted (allowed for a plate; "
            "abradem simulate --map)"
        )
    if not surrogate.description.get("jet_known", True):
        warn(["the jet of the table behind the model is not known; answers are for it alone"])
    if options.onnx:
        from abradem.surrogate.onnx import export_onnx

        try:
            export_onnx(surrogate, options.onnx)
        except ImportError:
            raise PredictionError("--onnx needs the package onnx: pip install onnx") from None
        if not options.values and options.table is None:
            return 0
    if options.table is not None:
        from abradem.cli.predict_table import predict_table

        predict_table(surrogate, given, options.table, options.output, depth, level)
        return 0
    target = target_of(surrogate, options.target)
    if options.solve is not None and depth is not None:
        wanted = Depth(depth, hours_of(options.hours))
        print_solution(surrogate, given, options.solve, wanted, level, target)
    elif options.extremes is not None:
        print_extremes(surrogate, given, options.extremes, level, target)
    else:
        _predict_case(surrogate, given, depth, level)
        if options.map is not None:
            model = options.model or default_model()
            print(predict_map(model, surrogate, given.values, options.map))
    return 0


def _surrogate(model: str | None) -> Surrogate | PredictionError:
    """Return the surrogate, or why it cannot be read: values are judged before."""
    try:
        return Surrogate.load(model or default_model())
    except PredictionError as error:
        return error


def _refuse_combinations(options: argparse.Namespace) -> None:
    """Raise with one line for each argument that needs or excludes another."""
    problems = []
    inverse = [f"--{name}" for name in ("solve", "extremes") if getattr(options, name) is not None]
    if len(inverse) == 2:
        problems.append("--solve and --extremes are two questions; ask one at a time")
    if inverse and options.table is not None:
        problems.append(f"{inverse[0]} is for a single case, not for --table FILE")
    if options.solve is not None and None in (options.depth, options.hours):
        problems.append("--solve needs --depth VALUE and --hours VALUE")
    if options.solve is None and options.hours is not None:
        problems.append("--hours is for --solve; --depth alone gives the hours")
    if inverse and options.map is not None:
        problems.append(f"--map is not for {inverse[0]}")
    if options.target is not None and not inverse:
        problems.append("--target is for --solve and --extremes; a prediction gives all places")
    if options.extremes is not None and options.depth is not None:
        problems.append("--depth is not for --extremes, which gives rates")
    if options.map is not None and options.table is not None:
        problems.append("--map is for a single prediction, not for --table FILE")
    if problems:
        raise PredictionError("\n".join(problems))


def _predict_case(
    surrogate: Surrogate, given: Given, depth: float | None, level: float | None
) -> None:
    found = surrogate.predict_all(given.values, level)
    first, *_ = found.values()
    warn(first.warnings)
    say_preset(given)
    for name, prediction in found.items():
        print(f"wear depth rate {rate_text(surrogate, name, prediction)}")
    if depth is None:
        return
    for name, prediction in found.items():
        middle, least, most = (float(column[0]) for column in prediction.hours_to(depth))
        print(
            f"{depth:g} mm after {middle:.4g} h, {least:.4g} to "
            f"{number_or_words(most, '.4g', NO_END)} h "
            f"({depth_words(surrogate, name)})"
        )


def default_model(config: Path = Path("config.yaml")) -> str:
    """Path, without suffix, of the surrogate of the study of a configuration."""
    import yaml

    from abradem.config.scalars import STUDY_NAME

    try:
        if not config.is_file():
            raise FileNotFoundError
        found = yaml.safe_load(config.read_text(encoding="utf-8"))
        study = found["study"]
    except FileNotFoundError:
        raise PredictionError(
            "--model is not given, and there is no config.yaml here to take the study from"
        ) from None
    except (OSError, yaml.YAMLError, ValueError, RecursionError, KeyError, TypeError):
        study = None
    if not (isinstance(study, str) and re.fullmatch(STUDY_NAME[1:-1], study)):
        raise PredictionError("--model is not given, and config.yaml names no study")
    return f"results/{study}/models/surrogate"


def _quantities() -> str:
    lines = []
    for row in SAMPLED:
        low, high = row.paper_range
        unit = "" if row.unit == "1" else row.unit
        lines.append(
            f"  {row.name:24} {unit:6} {low:g} ... {high:g}".ljust(54) + LABELS[row.name].long_name
        )
    return "\n".join(lines)


def _materials() -> str:
    plates = {f"{name} (the plate)": one for name, one in PLATE_MATERIALS.items()}
    presets = {**PARTICLE_MATERIALS, **plates}
    return "\n".join(f"  {name:20}{one.source}" for name, one in presets.items())

"""The command `abradem predict`: wear depth rate and service life of single cases or of a table.

Single cases need only numpy and safetensors; pandas and pyarrow are imported for tables.
"""

from __future__ import annotations

import argparse
import re
import sys
from pathlib import Path

from abradem.cli.given_values import (
    Given,
    add_material_argument,
    confidence_level,
    depth_mm,
    given_values,
    say_preset,
)
from abradem.cli.predict_map import check_map_path, predict_map
from abradem.config.materials import PARTICLE_MATERIALS, PLATE_MATERIALS
from abradem.learning.number_text import number_or_words
from abradem.quantities import SAMPLED
from abradem.surrogate.model import Prediction, PredictionError, Surrogate
from abradem.words.labels import LABELS
from abradem.words.wear import wear_words

NO_END = "any number of"

EPILOG = """\
quantities (unit, range of the paper, meaning):
{quantities}

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
        help="also print the hours until this wear depth, such as 5mm, in the mean over the plate "
        "or whatever the surrogate predicts; single places are worn deeper",
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
    if options.map is not None:
        check_map_path(options.map, options.table)
    given = given_values(options.values, options.material)
    depth = None if options.depth is None else depth_mm(options.depth)
    level = None if options.confidence is None else confidence_level(options.confidence)
    model = options.model or default_model()
    surrogate = Surrogate.load(model)
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
    _predict_case(surrogate, given, depth, level)
    if options.map is not None:
        print(predict_map(model, given.values, options.map))
    return 0


def _predict_case(
    surrogate: Surrogate, given: Given, depth: float | None, level: float | None
) -> None:
    prediction = surrogate.predict(given.values, level)
    warn(prediction.warnings)
    rate, low, high = (float(column[0]) for column in prediction[:3])
    name, unit = (surrogate.description["target"][key] for key in ("name", "unit"))
    place = place_words(surrogate)
    say_preset(given)
    print(
        f"wear depth rate {rate:.4g} {unit}, {level_text(prediction, surrogate)} interval "
        f"{low:.4g} to {number_or_words(high, '.4g', NO_END)} {unit} ({name}: {place})"
    )
    if depth is not None:
        middle, least, most = (float(column[0]) for column in prediction.hours_to(depth))
        print(
            f"{depth:g} mm after {middle:.4g} h, {least:.4g} to "
            f"{number_or_words(most, '.4g', NO_END)} h "
            f"({depth_words(surrogate)})"
        )


def level_text(prediction: Prediction, surrogate: Surrogate) -> str:
    """Return the level of an interval in percent, and why it is below the usual one."""
    text = f"{100.0 * prediction.confidence:.4g} %"
    if prediction.confidence == surrogate.highest_confidence < surrogate.usual_confidence:
        text += f" (the highest that {surrogate.score_count} held-out errors promise)"
    return text


def place_words(surrogate: Surrogate) -> str:
    """Return of what place of the plate the rate is that a surrogate predicts."""
    target = surrogate.description["target"]
    return wear_words(target["name"], target.get("element_size"))


def depth_words(surrogate: Surrogate) -> str:
    """Return of what the depth is that a surrogate predicts, in words."""
    words = f"depth {place_words(surrogate)}"
    worst = surrogate.description["target"]["name"].endswith("_max")
    return words if worst else f"{words}; single places are worn deeper"


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


def warn(lines: list[str]) -> None:
    """Print warnings to stderr."""
    for line in lines:
        print(f"warning: {line}", file=sys.stderr)


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

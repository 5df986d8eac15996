"""The command `abradem predict`: wear depth rate and service life of single cases or of a table.

Single cases need only numpy and safetensors; pandas and pyarrow are imported for tables.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

import numpy as np

from abradem.quantities import SAMPLED, SAMPLED_NAMES
from abradem.store.errors import TableError
from abradem.surrogate.materials import PARTICLE_MATERIALS, PLATE_MATERIALS, preset
from abradem.surrogate.model import PredictionError, Surrogate
from abradem.units import UNITS, parse_value
from abradem.words.labels import LABELS

EXAMPLE = """\
example:
  abradem predict --material granite plate_angle=45deg factory_angle=0deg \\
    particle_radius=20mm particle_velocity_y=-5m/s archard_constant=1e-9/Pa
"""


def add_parser(commands) -> None:
    """Add the command to the subparsers of the command line."""
    parser = commands.add_parser(
        "predict",
        help="predict the wear depth rate of a plate, with an interval",
        description="Predict the mean wear depth rate of a plate with the surrogate of a study.",
        epilog=f"quantities:\n{_quantities()}\n\nmaterials:\n{_materials()}\n\n{EXAMPLE}",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument(
        "values", nargs="*", metavar="NAME=VALUE", help="such as particle_radius=20mm"
    )
    parser.add_argument(
        "--material",
        choices=sorted(PARTICLE_MATERIALS),
        help="preset for the quantities that are not given, on a steel plate",
    )
    parser.add_argument(
        "--model",
        metavar="STEM",
        help="surrogate files without suffix; default: results/<study>/models/surrogate with the "
        "study of ./config.yaml",
    )
    parser.add_argument(
        "--confidence",
        type=float,
        default=0.95,
        metavar="P",
        help="level of the interval; default: 0.95",
    )
    parser.add_argument(
        "--depth", metavar="VALUE", help="also print the hours until this wear depth, such as 5mm"
    )
    parser.add_argument(
        "--table", type=Path, metavar="FILE",
        help="predict many cases: .csv or .parquet with the quantities as columns; missing columns "
        "are taken from NAME=VALUE and --material",
    )  # fmt: skip
    parser.add_argument(
        "--output",
        type=Path,
        metavar="FILE",
        help="write the table with predictions, .csv or .parquet",
    )
    parser.add_argument(
        "--onnx", type=Path, metavar="FILE", help="write the surrogate as ONNX (extra: onnx)"
    )
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Run the command and return the exit code."""
    surrogate = Surrogate.load(options.model or default_model())
    depth = None if options.depth is None else _depth(options.depth)
    if options.onnx:
        from abradem.surrogate.onnx import export_onnx

        try:
            export_onnx(surrogate, options.onnx)
        except ImportError:
            raise PredictionError("--onnx needs the package onnx: pip install onnx") from None
        if not options.values and options.table is None:
            return 0
    given = _given(options)
    if options.table is not None:
        _predict_table(options, surrogate, given, depth)
        return 0
    if options.output is not None:
        raise PredictionError("--output needs --table FILE")
    prediction = surrogate.predict(given, options.confidence)
    _warn(prediction.warnings)
    rate, low, high = (float(column[0]) for column in prediction[:3])
    name, unit = (surrogate.description["target"][key] for key in ("name", "unit"))
    print(
        f"wear depth rate {rate:.4g} {unit}, {100.0 * options.confidence:g} % interval "
        f"{low:.4g} to {high:.4g} {unit} ({name})"
    )
    if depth is not None:
        middle, least, most = (float(column[0]) for column in prediction.hours_to(depth))
        print(f"{depth:g} mm after {middle:.4g} h, {least:.4g} to {most:.4g} h")
    return 0


def default_model(config: Path = Path("config.yaml")) -> str:
    """Path, without suffix, of the surrogate of the study of a configuration."""
    import yaml

    try:
        study = yaml.safe_load(config.read_text(encoding="utf-8"))["study"]
    except FileNotFoundError:
        raise PredictionError(
            "--model is not given, and there is no config.yaml here to take the study from"
        ) from None
    except (yaml.YAMLError, UnicodeDecodeError, KeyError, TypeError):
        raise PredictionError("--model is not given, and config.yaml names no study") from None
    return f"results/{study}/models/surrogate"


def _given(options: argparse.Namespace) -> dict[str, float]:
    """Quantities of the preset and of the command line; the command line takes precedence."""
    given = dict(preset(options.material)) if options.material else {}
    problems, seen = [], set()
    for text in options.values:
        name, equals, value = text.partition("=")
        if not equals:
            problems.append(f"{text!r} is not of the form NAME=VALUE")
        elif name not in SAMPLED_NAMES:
            problems.append(f"{name}: no such quantity; known are {', '.join(SAMPLED_NAMES)}")
        elif name in seen:
            problems.append(f"{name} is given twice")
        else:
            seen.add(name)
            try:
                given[name] = parse_value(name, value)
            except ValueError as error:
                problems.append(str(error))
    if problems:
        raise PredictionError("\n".join(problems))
    return given


def _depth(text: str) -> float:
    """Convert a depth to mm."""
    try:
        return 1e3 * parse_value("particle_radius", text if text[-1:].isalpha() else f"{text}mm")
    except ValueError:
        raise PredictionError(
            f"depth = {text!r} is not a length (units: {', '.join(UNITS['m'])}; mm by default)"
        ) from None


def _predict_table(options, surrogate: Surrogate, given: dict, depth: float | None) -> None:
    if options.output is None:
        raise PredictionError("--table needs --output FILE")
    table = _read(options.table)
    values = {name: np.full(len(table), value) for name, value in given.items()}
    values |= {name: table[name].to_numpy() for name in SAMPLED_NAMES if name in table}
    try:
        prediction = surrogate.predict(values, options.confidence)
    except PredictionError as error:
        lines = str(error).splitlines()
        raise PredictionError("\n".join(f"{options.table}: {line}" for line in lines)) from None
    _warn(prediction.warnings)
    unit = surrogate.description["target"]["unit"]
    columns = {
        "wear_depth_rate": (prediction.rate, unit),
        "wear_depth_rate_lower": (prediction.lower, unit),
        "wear_depth_rate_upper": (prediction.upper, unit),
    }
    if depth is not None:
        middle, least, most = prediction.hours_to(depth)
        columns |= {
            "hours": (middle, "h"), "hours_lower": (least, "h"), "hours_upper": (most, "h"),
        }  # fmt: skip
    _write(table, columns, options.output)
    print(f"{len(table)} cases predicted, written to {options.output}")


def _read(path: Path):
    import pandas as pd

    from abradem.store.tables import read_table

    readers = {".csv": pd.read_csv, ".parquet": read_table}
    if path.suffix not in readers:
        raise PredictionError(f"{path}: is neither .csv nor .parquet")
    try:
        table = readers[path.suffix](path)
    except TableError:
        raise
    except FileNotFoundError:
        raise PredictionError(f"{path}: there is no such file") from None
    except (ValueError, OSError) as error:
        reason = str(error).splitlines()[0] if str(error) else type(error).__name__
        raise PredictionError(f"{path}: cannot be read ({reason})") from None
    if not len(table):
        raise PredictionError(f"{path}: has no rows")
    return table


def _write(table, columns: dict, path: Path) -> None:
    from abradem.store.files import replacing

    if path.suffix not in (".csv", ".parquet"):
        raise PredictionError(f"{path}: is neither .csv nor .parquet")
    frame = table.assign(**{name: values for name, (values, _) in columns.items()})
    with replacing(path) as sink:
        if path.suffix == ".csv":
            frame.to_csv(sink, index=False)
            return
        import pyarrow as pa
        import pyarrow.parquet as pq

        arrow = pa.Table.from_pandas(frame, preserve_index=False)
        for place, field in enumerate(arrow.schema):
            unit = columns.get(field.name, (None, ""))[1]
            if unit:
                field = field.with_metadata({"units": unit})
                arrow = arrow.set_column(place, field, arrow.column(place))
        pq.write_table(arrow, sink)


def _warn(lines: list[str]) -> None:
    for line in lines:
        print(f"warning: {line}", file=sys.stderr)


def _quantities() -> str:
    return "\n".join(
        f"  {row.name:26}{'' if row.unit == '1' else row.unit:8}{LABELS[row.name].long_name}"
        for row in SAMPLED
    )


def _materials() -> str:
    plates = {f"{name} (the plate)": one for name, one in PLATE_MATERIALS.items()}
    presets = {**PARTICLE_MATERIALS, **plates}
    return "\n".join(f"  {name:20}{one.source}" for name, one in presets.items())

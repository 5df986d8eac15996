"""What `abradem simulate` and `abradem sweep` take: quantities, preset, set-up, duration, seed."""

from __future__ import annotations

import argparse
import json
import math
import sys
import time
from collections.abc import Callable, Collection, Iterable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from abradem.cli.arguments import InputError
from abradem.cli.given_values import Given, add_material_argument, say_preset, value_text
from abradem.surrogate.geometry_groups import numbers_of
from abradem.units import MM_PER_M, parse_quantity
from abradem.words.wear import WearTarget

if TYPE_CHECKING:
    from abradem.config import Config
    from abradem.dem.surface import Feed, Surface

LARGEST_SEED = 2**63 - 1


class OwnSetup(NamedTuple):
    """Set-up of a case of one's own.

    Attributes
    ----------
    config : Config
    origin : str
        Where the configuration is from, in words.
    setup : dict
        Plain values of a `abradem.Setup`.
    seed : int
    """

    config: Config
    origin: str
    setup: dict
    seed: int


def add_case_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments that describe a case and its set-up."""
    add_material_argument(parser)
    parser.add_argument(
        "--config",
        action="append",
        type=Path,
        metavar="FILE",
        help="set-up and ranges; may be given several times, later files override earlier ones. "
        "Default: ./config.yaml, and without it the default study",
    )
    parser.add_argument(
        "--set",
        action="append",
        default=[],
        metavar="KEY=VALUE",
        help="another value for a key of docs/config.md, such as factory.mass_rate_kg_s=10; may "
        "be given several times",
    )
    parser.add_argument(
        "--geometry",
        type=Path,
        metavar="FILE",
        help="mesh that the particles wear, .stl, .obj or .ply, instead of the plate or the "
        "geometry of the configuration; short for --set geometry.kind=mesh --set "
        "geometry.mesh.file=FILE without what the files say of the plate",
    )
    parser.add_argument(
        "--unit",
        metavar="UNIT",
        help="unit of the mesh: mm (default), cm, m or in; short for --set geometry.mesh.unit=UNIT",
    )
    parser.add_argument(
        "--duration",
        metavar="VALUE",
        help="simulated time, such as 5s; default: until the wear rate is accurate enough",
    )
    parser.add_argument(
        "--seed",
        type=int,
        metavar="N",
        help="of the random positions of the particles; default: that of the configuration",
    )
    parser.add_argument(
        "--model",
        metavar="STEM",
        help="surrogate files without suffix; default: results/<study>/models/surrogate, if it "
        "exists",
    )


def read_setup(options: argparse.Namespace, problems: list[str]) -> OwnSetup | None:
    """Return the set-up that the options describe, or None; problems are added, a line each."""
    from abradem.config import ConfigError, load_config, read_config, setup_dict
    from abradem.config.unused import REPLACED_BY_A_MESH

    duration = _duration(options.duration, problems)
    if options.seed is not None and not 0 <= options.seed <= LARGEST_SEED:
        problems.append(f"--seed {options.seed}: is outside 0 ... {LARGEST_SEED}")
    files = options.config or [path for path in [Path("config.yaml")] if path.is_file()]
    known = load_config({"study": "default"}).model_dump(mode="json")
    entries = [] if files else ["study=default"]
    if options.unit is not None and options.geometry is None:
        problems.append("--unit needs --geometry FILE")
    for text in [*_mesh_keys(options), *options.set]:
        try:
            entries.append(_entry(text, known))
        except InputError as error:
            problems.append(str(error))
    try:
        config = read_config(
            *files,
            command_line=entries,
            leave_out=REPLACED_BY_A_MESH if options.geometry is not None else (),
        )
    except ConfigError as error:
        problems += error.problems
        return None
    setup = setup_dict(config)
    if duration is not None:
        setup["duration"] = duration
    names = " ".join(str(path) for path in files)
    origin = names or "the default study"
    return OwnSetup(config, origin, setup, config.seed if options.seed is None else options.seed)


def own_geometry(own: OwnSetup | None) -> Mapping | None:
    """Return the geometry of a set-up as plain values, or None for the plate."""
    return None if own is None else own.setup.get("geometry")


def check_mesh(setup: Mapping) -> None:
    """Raise if the mesh of all cases cannot be used, before one is simulated."""
    from abradem.geometry.build import mesh_file
    from abradem.geometry.kinds import geometry_of
    from abradem.geometry.shape import GeometryError

    given = setup.get("geometry")
    if given is None or mesh_file(given) is None:
        return
    try:
        geometry_of(given["shape"]).shape(setup["facet_size"])
    except GeometryError as error:
        raise InputError(f"no case can be simulated: {error}") from None


def _duration(text: str | None, problems: list[str]) -> float | None:
    if text is None:
        return None
    try:
        duration = parse_quantity(text, "s")
        if duration > 0.0:
            return duration
        problems.append(f"--duration {text}: must be positive")
    except ValueError as error:
        problems.append(f"--duration {text}: {error}")
    return None


def _mesh_keys(options: argparse.Namespace) -> list[str]:
    """Return what --geometry and --unit stand for."""
    if options.geometry is None:
        return []
    name = json.dumps(str(options.geometry))
    keys = ["simulation.geometry.kind=mesh", f"simulation.geometry.mesh.file={name}"]
    return keys + ([f"simulation.geometry.mesh.unit={options.unit}"] if options.unit else [])


def _entry(text: str, known: Mapping) -> str:
    """Return KEY=VALUE as an entry for `read_config`: the section, and the rest as YAML.

    The sections above a key may be left out, so that factory.mass_rate_kg_s is
    simulation.factory.mass_rate_kg_s.
    """
    name, equals, value = (part.strip() for part in text.partition("="))
    if not (equals and name and value):
        raise InputError(f"--set {text}: is not of the form KEY=VALUE")
    keys = list(_paths(known))
    found = [key for key in keys if key == name] or [
        key for key in keys if key.endswith(f".{name}")
    ]
    if len(found) > 1:
        found = [key for key in found if key.startswith("simulation.")] or found
    if len(found) > 1:
        raise InputError(f"--set {text}: may mean {' or '.join(found)}; give more of the name")
    whole = found[0] if found else name
    if not found and name.partition(".")[0] not in known:
        whole = f"simulation.{name}"
    first, *rest = whole.split(".")
    if not rest:
        return f"{first}={value}"
    value = " ".join(value.split())
    lines = [f"{' ' * depth}{key}:" for depth, key in enumerate(rest)]
    return f"{first}=" + "\n".join(lines) + f" {value}\n"


def _paths(values: Mapping, above: str = "") -> Iterable[str]:
    for name, value in values.items():
        yield f"{above}{name}"
        if isinstance(value, Mapping):
            yield from _paths(value, f"{above}{name}.")


def headline(config: Config) -> WearTarget:
    """Return the wear rate that the models of a configuration explain."""
    from abradem.config import target_dict

    return WearTarget(**target_dict(config))


def middle_of_ranges(own: OwnSetup, given: Iterable[str]) -> dict[str, float]:
    """Return the quantities that are not given: the middle of the ranges of the study."""
    from abradem.config import geometry_ranges, sampled_ranges

    given = set(given)
    ranges = {**sampled_ranges(own.config), **geometry_ranges(own.config)}
    return {name: (low + high) / 2.0 for name, (low, high) in ranges.items() if name not in given}


def with_given_numbers(own: OwnSetup, given: Iterable[str]) -> OwnSetup:
    """Return the set-up whose geometry takes the numbers that are given from the case."""
    geometry: Mapping = own.setup.get("geometry") or {}
    numbers = numbers_of(geometry)
    changed = {name for name in given if isinstance(numbers.get(name), (int, float))}
    if not changed:
        return own
    shape = dict(geometry["shape"])
    if "plates" in shape:
        shape["plates"] = [
            _of_case(plate, f"plate_{place}", changed)
            for place, plate in enumerate(shape["plates"], 1)
        ]
    else:
        shape = _of_case(shape, shape["kind"], changed)
    return own._replace(setup={**own.setup, "geometry": {**geometry, "shape": shape}})


def _of_case(fields: Mapping, begin: str, changed: Collection[str]) -> dict:
    """Return fields of a geometry with the names of quantities for the numbers of these names."""
    return {
        field: f"{begin}_{field}" if f"{begin}_{field}" in changed else value
        for field, value in fields.items()
    }


def unused_values(own: OwnSetup | None, names: Iterable[str]) -> list[str]:
    """Return a line for each quantity that is given although nothing depends on it."""
    from abradem.config.unused import unused_quantities

    if own is None:
        return []
    kind = own.config.simulation.geometry.kind
    return [
        f"{name}: means nothing with geometry.kind: {kind} (allowed without it)"
        for name in unused_quantities(own.config)
        if name in names
    ]


def say_origins(given: Given, own: OwnSetup, filled: Mapping[str, float]) -> None:
    """Print where the quantities that are not on the command line come from."""
    from abradem.config.unused import unused_quantities

    say_preset(given)
    unused = unused_quantities(own.config)
    filled = {name: value for name, value in filled.items() if name not in unused}
    if filled:
        values = ", ".join(value_text(name, value) for name, value in sorted(filled.items()))
        print(f"not given, middle of the ranges of {own.origin}: {values}", file=sys.stderr)


def surface_words(surface: Surface) -> str:
    """Extent of a surface, mm, and its cells, as text: what shows a wrong unit."""
    wide, high, deep = MM_PER_M * (surface.vertices.max(axis=0) - surface.vertices.min(axis=0))
    cells, parts = len(surface.triangles), len(surface.part_names)
    return (
        f"surface of {wide:.4g} x {high:.4g} x {deep:.4g} mm along x, y and z, {cells} cells in "
        f"{parts} part{'' if parts == 1 else 's'}"
    )


def patch_words(feed: Feed) -> str:
    """Extent and place of the factory, mm, as text."""
    length, width = (MM_PER_M * math.hypot(*edge) for edge in (feed.along, feed.across))
    x, y, z = (MM_PER_M * number for number in feed.centre)
    return (
        f"factory of {length:.4g} x {width:.4g} mm, centre at x = {x:.4g}, y = {y:.4g}, "
        f"z = {z:.4g} mm"
    )


def load_kernels(setup: Mapping, threads: int = 1) -> None:
    """Load the kernels of the engine for a set-up; say so if they have to be compiled first."""
    from abradem.dem import warm
    from abradem.dem.cache import compiling_words, is_compiled
    from abradem.simulation.batch import kernels_needed

    for stepping, on_surface in kernels_needed(setup, threads):
        begin = time.monotonic()
        compiles = not is_compiled(stepping, on_surface)
        if compiles:
            words = compiling_words(on_surface)
            print(f"compiling the engine, {words}", file=sys.stderr, flush=True)
        warm.load(stepping, on_surface)
        if compiles:
            print(f"compiled in {time.monotonic() - begin:.0f} s", file=sys.stderr)


def progress_line(setup: Mapping) -> tuple[Callable[[float], None] | None, Callable[[], None]]:
    """Return what shows the simulated time on a terminal, or None, and what clears the line."""
    from abradem.running.job_log import CLEAR

    if not sys.stderr.isatty():
        return None, lambda: None
    duration = setup.get("duration")
    end = f"of {duration:g} s" if duration else f"s, at most {setup['max_time']:g} s"
    shown = [0.0]

    def progress(simulated: float) -> None:
        if time.monotonic() - shown[0] > 0.2:
            shown[0] = time.monotonic()
            print(f"{CLEAR}simulated {simulated:.2f} {end}", end="", file=sys.stderr, flush=True)

    def clear() -> None:
        print(CLEAR, end="", file=sys.stderr, flush=True)

    return progress, clear

"""Checks of the two files of a surrogate when it is loaded: all parts, of the right type and size.

A surrogate is copied and sent; a part that is missing, of another version or damaged would give a
wrong number or an error far from its cause.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from abradem.quantities import quantity
from abradem.surrogate.geometry_groups import numbers_of
from abradem.surrogate.groups import Jet, group_names, input_names

NETWORKS = ("mean", "spread")
"""Networks for the logarithm of the wear number and of its standard deviation."""

UNIT = "mm/s"
"""Unit of the wear depth rate, that of `abradem.surrogate.groups.wear_scale`."""


class PartError(ValueError):
    """A part of a surrogate is missing or wrong; the message is one line."""


def check_description(description: Any) -> None:
    """Check the content of the JSON file; raise `PartError` with the first fault.

    Parameters
    ----------
    description : object
        What the file holds, of any type.
    """
    _typed(description, Mapping, "the content", "an object")
    if description.get("kind") != "surrogate":
        raise PartError(f"kind = {description.get('kind')!r} must be 'surrogate'")
    groups = _part(description, "groups", list, "a list")
    jet = checked_jet(_part(description, "jet", Mapping, "an object"))
    if groups != list(group_names(jet)):
        raise PartError(f"groups = {_shown(groups)} must be {', '.join(group_names(jet))}")
    _check_target(description, "")
    for place, one in enumerate(_typed(description.get("local", []), list, "local", "a list")):
        _typed(one, Mapping, f"local[{place}]", "an object")
        _check_target(one, f"local[{place}].")
    rates = [description, *description.get("local", [])]
    names = [one["target"]["name"] for one in rates]
    if twice := sorted({name for name in names if names.count(name) > 1}):
        raise PartError(f"{twice[0]} is the target twice")
    above = {name: one.get("at_least") for name, one in zip(names, rates, strict=True)}
    for name, floor in above.items():
        if floor is not None and (floor not in above or above[floor] is not None):
            raise PartError(f"at_least = {_shown(floor)} of {name} must be another wear rate")
    if "domain" in description:
        domain = _part(description, "domain", Mapping, "an object")
        if not _number(domain.get("limit"), "domain.limit") >= 0.0:
            raise PartError(f"domain.limit = {domain['limit']!r} must not be negative")
    _typed(description.get("jet_known", True), bool, "jet_known", "true or false")
    _check_features(_part(description, "features", list, "a list"), input_names(jet))


def local_names(description: Mapping) -> list[str]:
    """Names of the wear rates of a surrogate besides the target of its study."""
    return [one["target"]["name"] for one in description.get("local", [])]


def local_prefix(name: str) -> str:
    """What the names of the arrays of a wear rate begin with, if it is not the target."""
    return f"local.{name}."


def _check_target(parent: Mapping, above: str) -> None:
    target = _part(parent, "target", Mapping, "an object", above)
    at = f"{above}target."
    if not _part(target, "name", str, "text", at):
        raise PartError(f"{at}name is empty")
    if _part(target, "unit", str, "text", at) != UNIT:
        raise PartError(f"{at}unit = {target['unit']!r} must be {UNIT!r}")
    _typed(target.get("known", True), bool, f"{at}known", "true or false")
    if "element_size" in target and not _number(target["element_size"], f"{at}element_size") > 0:
        raise PartError(f"{at}element_size = {target['element_size']!r} must be positive")


def checked_jet(jet: Mapping) -> Jet:
    """The jet of a stored model; raise `PartError` with the first fault."""
    fields = [name for name in Jet._fields if name != "geometry"]
    if set(jet) - {"geometry"} != set(fields):
        raise PartError(f"jet has {_shown(sorted(jet))}, must have {', '.join(fields)}")
    rates = [name for name in ("mass_rate", "number_rate") if jet[name] is not None]
    if len(rates) != 1:
        raise PartError("jet must have either mass_rate or number_rate")
    for name in ("fall_height", "gravity"):
        if not _number(jet[name], f"jet.{name}") >= 0.0:
            raise PartError(f"jet.{name} = {jet[name]!r} must not be negative")
    for name in (*rates, "plate_area", "patch_area"):
        if not _number(jet[name], f"jet.{name}") > 0.0:
            raise PartError(f"jet.{name} = {jet[name]!r} must be positive")
    if jet.get("geometry") is not None:
        _check_geometry(jet["geometry"])
    return Jet(**jet)


def _check_geometry(geometry: Any) -> None:
    """Check that a geometry has a kind, and numbers or sampled quantities where they belong."""
    shape = _part(_typed(geometry, Mapping, "jet.geometry", "an object"), "shape", Mapping,
                  "an object", "jet.geometry.")  # fmt: skip
    at = "jet.geometry.shape."
    kind = _part(shape, "kind", str, "text", at)
    if kind == "plates":
        for place, plate in enumerate(_part(shape, "plates", list, "a list", at)):
            _typed(plate, Mapping, f"{at}plates[{place}]", "an object")
    for name, value in numbers_of(geometry).items():
        if value not in (name, "plate_angle"):
            _number(value, f"jet.geometry: {name}")
    if "screw_revolutions" in numbers_of(geometry) and "screw_radius" not in numbers_of(geometry):
        raise PartError(f"{at}radius is missing")


def _check_features(features: list, known: Sequence[str]) -> None:
    names = []
    units = {name: quantity(name).unit for name in known}
    for place, feature in enumerate(features):
        at = f"features[{place}]"
        _typed(feature, Mapping, at, "an object")
        name = _part(feature, "name", str, "text", f"{at}.")
        if name not in units:
            raise PartError(f"{at}.name = {name!r} is no quantity")
        names.append(name)
        unit = _part(feature, "unit", str, "text", f"{at}.")
        if unit != units[name]:
            raise PartError(f"{at}.unit = {unit!r} of {name} must be {units[name]!r}")
        ends = _part(feature, "training_range", list, "a list", f"{at}.")
        if len(ends) != 2:
            raise PartError(f"{at}.training_range has {len(ends)} numbers, must have 2")
        low, high = (_number(end, f"{at}.training_range") for end in ends)
        if low > high:
            raise PartError(f"{at}.training_range = {_shown(ends)} is not in order")
    missing = [name for name in units if name not in names]
    twice = sorted({name for name in names if names.count(name) > 1})
    if missing or twice:
        raise PartError(
            f"features lack {', '.join(missing)}" if missing else f"features name {twice[0]} twice"
        )


def check_arrays(
    arrays: Mapping[str, np.ndarray],
    width: int,
    local: Sequence[str] = (),
    domain: bool = False,
) -> None:
    """Check the content of the safetensors file; raise `PartError` with the first fault.

    Parameters
    ----------
    arrays : mapping of str to ndarray
    width : int
        Number of groups.
    local : sequence of str
        From `local_names`.
    domain : bool
        Whether the training cases must be there.
    """
    for name in ("group_mean", "group_scale"):
        _array(arrays, name, (width,))
    if not (arrays["group_scale"] > 0.0).all():
        raise PartError("group_scale must be positive")
    if domain:
        _array(arrays, "domain_rows", (None, width))
        _array(arrays, "domain_slopes", (width,))
    for prefix in ("", *map(local_prefix, local)):
        _check_rate(arrays, prefix, width)


def _check_rate(arrays: Mapping[str, np.ndarray], prefix: str, width: int) -> None:
    scores = _array(arrays, f"{prefix}conformal", (None,))
    if not len(scores) or (scores < 0.0).any():
        raise PartError(f"{prefix}conformal must hold scores that are not negative, at least one")
    for network in (f"{prefix}{name}" for name in NETWORKS):
        count = sum(name.startswith(f"{network}_weights_") for name in arrays)
        if not count:
            raise PartError(f"{network}_weights_0 is missing")
        inputs = width
        for place in range(count):
            weights = _array(arrays, f"{network}_weights_{place}", (inputs, None))
            inputs = weights.shape[1]
            _array(arrays, f"{network}_biases_{place}", (inputs,))
        if inputs != 1:
            raise PartError(f"{network}_weights_{count - 1} has {inputs} outputs, must have 1")


def _array(arrays: Mapping, name: str, shape: tuple[int | None, ...]) -> np.ndarray:
    """The array of a name, checked; None in the shape is any length."""
    if name not in arrays:
        raise PartError(f"{name} is missing")
    array = arrays[name]
    if array.dtype.kind != "f":
        raise PartError(f"{name} has type {array.dtype}, must be floating-point numbers")
    fits = array.ndim == len(shape) and all(
        asked in (None, found) for asked, found in zip(shape, array.shape, strict=True)
    )
    if not fits:
        asked = ", ".join("any" if length is None else str(length) for length in shape)
        raise PartError(f"{name} has shape {array.shape}, must have ({asked})")
    if not np.isfinite(array).all():
        raise PartError(f"{name} has values that are not finite")
    return array


def _part(parent: Mapping, name: str, kind: type, words: str, above: str = "") -> Any:
    if name not in parent:
        raise PartError(f"{above}{name} is missing")
    return _typed(parent[name], kind, f"{above}{name}", words)


def _typed(value: Any, kind: type, name: str, words: str) -> Any:
    if not isinstance(value, kind):
        raise PartError(f"{name} = {_shown(value)} must be {words}")
    return value


def _number(value: Any, name: str) -> float:
    try:
        number = float("nan") if isinstance(value, bool | str) else float(value)
    except (TypeError, ValueError, OverflowError):
        number = float("nan")
    if not np.isfinite(number):
        raise PartError(f"{name} = {_shown(value)} must be a finite number")
    return number


def _shown(value: Any) -> str:
    text = repr(value)
    return text if len(text) <= 80 else f"{text[:80]}..."

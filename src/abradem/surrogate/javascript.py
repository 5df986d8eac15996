"""The formulas of the dimensionless groups as JavaScript, for pages that predict.

As for ONNX (`abradem.surrogate.onnx`), no formula is written a second time: the functions of
`abradem.surrogate.groups` run on symbols that record each operation as a line. JavaScript computes
in double precision, as numpy does.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from abradem.surrogate.groups import Jet, group_columns, input_names, wear_scale

_INFIX = {np.add: "+", np.subtract: "-", np.multiply: "*", np.divide: "/", np.power: "**"}
_CALLS = {
    np.maximum: "Math.max", np.log: "Math.log", np.sqrt: "Math.sqrt", np.cos: "Math.cos",
    np.exp: "Math.exp",
}  # fmt: skip


class _Symbol(np.lib.mixins.NDArrayOperatorsMixin):
    """A value of the function that is written; it supports numpy arithmetic."""

    def __init__(self, lines: list[str], text: str):
        self.lines, self.text = lines, text

    def __array_ufunc__(self, ufunc, method, *inputs, **keywords):
        known = ufunc in _INFIX or ufunc in _CALLS
        if method != "__call__" or keywords or not known:
            raise TypeError(f"{ufunc.__name__} has no counterpart in JavaScript")
        texts = [_text(one) for one in inputs]
        if ufunc in _INFIX:
            # Negative constants in brackets, as ** takes no bare sign.
            value = f" {_INFIX[ufunc]} ".join(texts)
        else:
            value = f"{_CALLS[ufunc]}({', '.join(texts)})"
        name = f"t{len(self.lines)}"
        self.lines.append(f"  const {name} = {value};")
        return _Symbol(self.lines, name)


def _text(value) -> str:
    return value.text if isinstance(value, _Symbol) else f"({float(value)!r})"


def group_functions(jet: Jet) -> str:
    """Source of two functions of an object with the quantities of a prediction.

    Parameters
    ----------
    jet : Jet

    Returns
    -------
    str
        ``dimensionlessGroups(values)`` returns the list of `abradem.surrogate.groups.group_names`,
        ``wearScale(values)`` the scale of the wear depth rate in mm/s. The values are in the units
        of `abradem.quantities`.
    """
    return "\n".join(
        (
            _function("dimensionlessGroups", jet, group_columns, True),
            _function("wearScale", jet, lambda values, jet: [wear_scale(values, jet)], False),
        )
    )


def _function(name: str, jet: Jet, computed: Callable, many: bool) -> str:
    lines: list[str] = []
    values = {key: _Symbol(lines, f"values.{key}") for key in input_names(jet)}
    results = ", ".join(_text(one) for one in computed(values, jet))
    returned = f"[{results}]" if many else results
    return "\n".join([f"function {name}(values) {{", *lines, f"  return {returned};", "}"])

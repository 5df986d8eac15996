"""Export of the surrogate as an ONNX graph, for use outside Python; needs the extra ``onnx``.

The inputs of the graph are the sampled quantities, those of a geometry included, each a vector
(n,) in double precision in the unit of `abradem.quantities`. The outputs are the wear depth rate
(mm/s) and the standard deviation of its logarithm, both (n,). The formulas for the groups are not
written a second time: the functions of `abradem.surrogate.groups` run on symbols that record each
operation as a node.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from abradem.store.files import replacing
from abradem.surrogate.groups import group_columns, input_names, wear_scale
from abradem.surrogate.model import Surrogate
from abradem.surrogate.networks import Layers
from abradem.surrogate.parts import NETWORKS

OPSET = 17
RATE, DEVIATION = OUTPUTS = ("wear_depth_rate", "log_deviation")

_OPERATORS = {
    np.add: "Add", np.subtract: "Sub", np.multiply: "Mul", np.divide: "Div",
    np.power: "Pow", np.maximum: "Max", np.log: "Log", np.sqrt: "Sqrt", np.cos: "Cos",
    np.exp: "Exp",
}  # fmt: skip


class _Graph:
    """Nodes and constants recorded so far."""

    def __init__(self):
        self.nodes, self.constants = [], []

    def constant(self, values, dtype=np.float64) -> str:
        from onnx import numpy_helper

        name = f"c{len(self.constants)}"
        self.constants.append(numpy_helper.from_array(np.asarray(values, dtype=dtype), name))
        return name

    def node(self, operator: str, *inputs: str, name: str = "", **attributes) -> str:
        from onnx import helper

        name = name or f"n{len(self.nodes)}"
        self.nodes.append(helper.make_node(operator, list(inputs), [name], **attributes))
        return name


class _Symbol(np.lib.mixins.NDArrayOperatorsMixin):
    """A value of the graph that supports numpy arithmetic."""

    def __init__(self, graph: _Graph, name: str):
        self.graph, self.name = graph, name

    def __array_ufunc__(self, ufunc, method, *inputs, **keywords):
        if method != "__call__" or keywords or ufunc not in _OPERATORS:
            raise TypeError(f"{ufunc.__name__} has no counterpart in the ONNX graph")
        names = [
            one.name if isinstance(one, _Symbol) else self.graph.constant(one) for one in inputs
        ]
        return _Symbol(self.graph, self.graph.node(_OPERATORS[ufunc], *names))


def export_onnx(surrogate: Surrogate, path: str | Path) -> None:
    """Write the surrogate as an ONNX file; the file is written completely or not at all.

    Parameters
    ----------
    surrogate : Surrogate
    path : path

    Raises
    ------
    ImportError
        If the package ``onnx`` is missing.
    """
    from onnx import TensorProto, checker, helper

    graph = _Graph()
    values = {name: _Symbol(graph, name) for name in input_names(surrogate.jet)}
    axis = graph.constant([1], np.int64)
    found = group_columns(values, surrogate.jet)
    columns = [graph.node("Unsqueeze", column.name, axis) for column in found]
    groups = graph.node("Concat", *columns, axis=1)
    centred = graph.node("Sub", groups, graph.constant(surrogate.group_mean))
    scaled = graph.node("Div", centred, graph.constant(surrogate.group_scale))
    z = graph.node("Cast", scaled, to=TensorProto.FLOAT)

    # A symbol, which numpy functions take.
    def output(layers: Layers) -> Any:
        value = z
        for place, (weights, biases) in enumerate(layers):
            value = graph.node("Relu", value) if place else value
            value = graph.node(
                "Gemm", value, graph.constant(weights, np.float32),
                graph.constant(biases, np.float32),
            )  # fmt: skip
        squeezed = graph.node("Squeeze", value, axis)
        return _Symbol(graph, graph.node("Cast", squeezed, to=TensorProto.DOUBLE))

    target = surrogate.model()
    mean, spread = (output(target.layers[network]) for network in NETWORKS)
    if target.at_least is not None:
        mean = np.maximum(mean, output(surrogate.models[target.at_least].layers[NETWORKS[0]]))
    rate = wear_scale(values, surrogate.jet) * np.exp(mean)
    graph.node("Identity", rate.name, name=RATE)
    graph.node("Exp", spread.name, name=DEVIATION)

    def column(name: str):
        return helper.make_tensor_value_info(name, TensorProto.DOUBLE, ["n"])

    model = helper.make_model(
        helper.make_graph(
            graph.nodes,
            "abradem_surrogate",
            [column(name) for name in input_names(surrogate.jet)],
            [column(name) for name in OUTPUTS],
            graph.constants,
        ),
        opset_imports=[helper.make_opsetid("", OPSET)],
        ir_version=8,
        producer_name="abradem",
    )
    checker.check_model(model)
    with replacing(path) as sink:
        sink.write(model.SerializeToString())

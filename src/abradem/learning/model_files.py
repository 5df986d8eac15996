"""Model files: arrays in safetensors, everything else in JSON, no executable code in either.

A model is stored in two files. ``<stem>.safetensors`` holds its arrays. ``<stem>.json`` holds
everything else that is needed to use and assess it: features in order with units, scalers and
training ranges, target, protocol, hash of the training data, and scores. `load_model` reads all
kinds:

``linear``
    y = coefficients . z, also used for the regression on principal components.
``trees``
    Mean of one or more binary trees; a row goes left if feature <= threshold.
``network``
    Fully connected layers with rectified linear units between them.

Here z = (features - mean) / scale. The model predicts the scaled target, which is scaled back.
"""

from __future__ import annotations

import warnings
from pathlib import Path

import numpy as np
import pandas as pd

from abradem.learning.rows import Scaler, Table
from abradem.quantities import quantity
from abradem.store.files import TableError, read_arrays, read_json, write_arrays, write_json
from abradem.store.tables import write_table

KINDS = ("linear", "trees", "network")


def about(
    table: Table,
    model: str,
    protocol: str,
    kind: str,
    scalers: tuple[Scaler, Scaler],
    rows: np.ndarray | None = None,
    columns: np.ndarray | None = None,
    **more,
) -> dict:
    """Description of a model, the content of its JSON file.

    Parameters
    ----------
    table : Table
        Rows that the model was trained on.
    model, protocol : str
    kind : {"linear", "trees", "network"}
    scalers : pair of Scaler
        Scalers of the features used and of the target.
    rows : ndarray of int, optional
        Training rows; by default all.
    columns : ndarray of int, optional
        Features used; by default all.
    more
        Further entries, such as hyper-parameters and scores.
    """
    rows = np.arange(len(table.target)) if rows is None else rows
    columns = np.arange(len(table.names)) if columns is None else columns
    of_features, of_target = scalers
    means, scales = np.atleast_1d(of_features.mean), np.atleast_1d(of_features.scale)
    features = []
    for place, column in enumerate(columns):
        row, values = quantity(table.names[column]), table.features[rows, column]
        features.append(
            {
                "symbol": row.symbol,
                "name": row.name,
                "unit": row.unit,
                "mean": means[place],
                "scale": scales[place],
                "training_range": [values.min(), values.max()],
            }
        )
    return {
        "model": model,
        "protocol": protocol,
        "table": table.name,
        "kind": kind,
        "features": features,
        "target": {
            "name": table.target_name,
            "unit": table.unit,
            "mean": of_target.mean,
            "scale": of_target.scale,
        },
        "training_rows": len(rows),
        "dataset_hash": table.hash,
        **more,
    }


def write_model(description: dict, arrays: dict[str, np.ndarray], path: str | Path) -> None:
    """Write ``description`` to ``path`` (JSON) and ``arrays`` next to it (safetensors)."""
    write_arrays(arrays, Path(path).with_suffix(".safetensors"))
    write_json(description, path)


class Model:
    """A model read from its files.

    Attributes
    ----------
    description : dict
    arrays : dict of str to ndarray
    """

    def __init__(self, description: dict, arrays: dict[str, np.ndarray]):
        if description.get("kind") not in KINDS:
            raise TableError(f"kind {description.get('kind')!r} is unknown; known: {KINDS}")
        self.description = description
        self.arrays = arrays

    def predict(self, rows: pd.DataFrame) -> np.ndarray:
        """Predict the target; warns if features lie outside the training ranges.

        Parameters
        ----------
        rows : pandas.DataFrame
            Holds the features of the model in the units of its description.

        Returns
        -------
        ndarray, shape (n,)
            In the unit of the target.

        Raises
        ------
        TableError
            If a feature is missing.
        """
        features = self.description["features"]
        missing = [feature["name"] for feature in features if feature["name"] not in rows]
        if missing:
            raise TableError(f"rows: lack column {', '.join(missing)}")
        x = rows[[feature["name"] for feature in features]].to_numpy(dtype=float)
        for values, feature in zip(x.T, features, strict=True):
            low, high = feature["training_range"]
            # Written so that nan counts as outside.
            beyond = int(np.sum(~((values >= low) & (values <= high))))
            if beyond:
                warnings.warn(
                    f"{feature['name']}: {beyond} of {len(values)} values lie outside the "
                    f"training range {low:g} ... {high:g} {feature['unit']}",
                    stacklevel=2,
                )
        mean, scale = (np.array([f[name] for f in features]) for name in ("mean", "scale"))
        target = self.description["target"]
        return target["mean"] + target["scale"] * self._scaled((x - mean) / scale)

    def _scaled(self, z: np.ndarray) -> np.ndarray:
        arrays = self.arrays
        if self.description["kind"] == "linear":
            return z @ arrays["coefficients"]
        if self.description["kind"] == "trees":
            return predict_trees(arrays, z)
        return predict_network(arrays, z)


def load_model(path: str | Path) -> Model:
    """Read a model from its JSON file and the safetensors file next to it."""
    return Model(read_json(path), read_arrays(Path(path).with_suffix(".safetensors")))


def predict_network(arrays: dict[str, np.ndarray], z: np.ndarray) -> np.ndarray:
    """Output of a network for scaled rows.

    Parameters
    ----------
    arrays : dict of str to ndarray
        ``weights_0`` (in, out), ``biases_0`` (out,), ``weights_1``, ... from the input on.
    z : ndarray, shape (n, p)

    Returns
    -------
    ndarray, shape (n,)
    """
    layer, values = 0, z.astype(np.float32)
    while f"weights_{layer}" in arrays:
        values = np.maximum(values, 0.0) if layer else values
        # OpenBLAS sets the flag of an invalid operation on some processors where all is finite
        # (github.com/numpy/numpy/issues/24067); a value that is not finite is returned as it is.
        with np.errstate(invalid="ignore"):
            values = values @ arrays[f"weights_{layer}"]
        values = values + arrays[f"biases_{layer}"]
        layer += 1
    return values[:, 0].astype(float)


def tree_arrays(trees: list) -> dict[str, np.ndarray]:
    """Node arrays of fitted scikit-learn trees, one tree after the other.

    Returns
    -------
    dict of str to ndarray
        ``feature``, ``threshold``, ``left``, ``right`` and ``value`` of every node, and ``root``,
        the index of the first node of each tree. ``left`` and ``right`` are node indices, -1 at a
        leaf.
    """
    parts: dict[str, list] = {name: [] for name in ("feature", "threshold", "left", "right")}
    values, roots, first = [], [], 0
    for tree in (estimator.tree_ for estimator in trees):
        inner = tree.children_left >= 0
        parts["feature"].append(np.where(inner, tree.feature, -1))
        parts["threshold"].append(np.where(inner, tree.threshold, 0.0))
        parts["left"].append(np.where(inner, tree.children_left + first, -1))
        parts["right"].append(np.where(inner, tree.children_right + first, -1))
        values.append(tree.value[:, 0, 0])
        roots.append(first)
        first += tree.node_count
    arrays = {name: np.concatenate(part) for name, part in parts.items()}
    for name in ("feature", "left", "right"):
        arrays[name] = arrays[name].astype(np.int64)
    return {**arrays, "value": np.concatenate(values), "root": np.array(roots, dtype=np.int64)}


def predict_trees(arrays: dict[str, np.ndarray], z: np.ndarray) -> np.ndarray:
    """Mean prediction of the trees of `tree_arrays` for standardised rows (n, p), shape (n,)."""
    # scikit-learn compares features and thresholds in single precision.
    z = z.astype(np.float32)
    total = np.zeros(len(z))
    rows = np.arange(len(z))
    for root in arrays["root"]:
        node = np.full(len(z), root)
        while (inner := arrays["left"][node] >= 0).any():
            at = node[inner]
            lower = z[rows[inner], arrays["feature"][at]] <= arrays["threshold"][at]
            node[inner] = np.where(lower, arrays["left"][at], arrays["right"][at])
        total += arrays["value"][node]
    return total / len(arrays["root"])


def write_stage(outputs, /, **results) -> None:
    """Write the results of a learning stage, each to the output path of the same name.

    Parameters
    ----------
    outputs : mapping of str to path
        A model needs two paths, ``<name>`` and ``<name>_arrays``.
    results
        DataFrames are written as tables, dictionaries as JSON, pairs (description, arrays) as
        models.

    Raises
    ------
    ValueError
        If an output has no result, or the arrays of a model do not belong next to its JSON file.
    """
    paths = dict(outputs)
    for name, result in results.items():
        path = paths.pop(name)
        if isinstance(result, pd.DataFrame):
            write_table(result, path)
        elif isinstance(result, dict):
            write_json(result, path)
        else:
            if Path(paths.pop(f"{name}_arrays")) != Path(path).with_suffix(".safetensors"):
                raise ValueError(f"the arrays of {name} must be in the same folder as {path}")
            description, arrays = result
            write_model(description, arrays, path)
    if paths:
        raise ValueError(f"nothing to write to {', '.join(map(str, paths.values()))}")

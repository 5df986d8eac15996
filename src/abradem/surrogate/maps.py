"""Prediction of the wear map of a plate, with the map surrogate of a study.

A study writes its map surrogate to ``wear_maps.json`` and ``wear_maps.safetensors``
(`abradem.learning.physical.wear_maps` fits it). For n elements of a plate ::

    rate_i = s N p_i                                          (mm/s)
    p_i    = max(exp(m_i + sum_k a_k phi_ik) - f, 0), scaled to a mean of 1
    ln N, a_k: polynomials of second order in the standardised dimensionless groups

with the scale s of the wear (`abradem.surrogate.groups.wear_scale`), the wear number N of the mean
over the plate and the *shape* p of the map, whose mean is 1. The modes phi are those of a proper
orthogonal decomposition of ln(p + f) (Lumley 1967; Sirovich 1987, Q. Appl. Math. 45:561). The floor
f, in means over the plate, makes elements without wear finite. Groups beyond those of the training
cases are set to the nearest of them, as a polynomial grows without bound.

The map is that of a long time: it lacks the noise of the window of a simulation, whose worst
element is worn faster.

Only numpy and safetensors are needed.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from abradem.quantities import SAMPLED_NAMES, WEAR_MEASURES
from abradem.store.checksums import remedy
from abradem.surrogate.groups import GROUP_NAMES, Jet, group_matrix, wear_scale
from abradem.surrogate.inputs import PredictionError
from abradem.surrogate.stored import stored_model
from abradem.units import MM_PER_M

STEM = "wear_maps"
"""Name of the files of the map surrogate, without suffix, beside those of the surrogate."""

KIND = "wear_maps"


class WearMaps(NamedTuple):
    """Predicted wear maps of n cases.

    Attributes
    ----------
    rate : ndarray, shape (n, nx, nz)
        Wear depth rate of the elements, mm/s.
    x, z : ndarray, shape (nx,) and (nz,)
        Centres of the elements along the slope and across, mm from the centre of the plate.
    """

    rate: np.ndarray
    x: np.ndarray
    z: np.ndarray


class MapSurrogate:
    """A map surrogate, usually read from its files by `load`.

    Parameters
    ----------
    description : mapping
        Content of the JSON file.
    arrays : mapping of str to ndarray
        Content of the safetensors file: ``group_mean``, ``group_scale``, ``group_low``,
        ``group_high`` (10,), ``coefficients`` (66, 1 + k), of ln N and of the k modes,
        ``mean_map`` (nx, nz) and ``modes`` (k, nx, nz).
    """

    def __init__(self, description: Mapping, arrays: Mapping[str, np.ndarray]):
        self.description = dict(description)
        self.arrays = dict(arrays)
        self.jet = Jet(**description["jet"])

    @classmethod
    def load(cls, path: str | Path) -> MapSurrogate:
        """Read a map surrogate from its JSON file and the safetensors file next to it.

        Parameters
        ----------
        path : path
            The JSON file.

        Raises
        ------
        PredictionError
            If a file is missing or damaged, or is no map surrogate.
        """
        path = Path(path)
        description, arrays = stored_model(
            path,
            "a study makes it with `snakemake physical`, unless it learns from a table, which "
            "holds no maps",
        )
        if fault := _fault(description, arrays):
            line = f"{path}: damaged, or no map surrogate ({fault}){remedy(path)}"
            raise PredictionError(line)
        return cls(description, arrays)

    def predict(self, values: Mapping[str, ArrayLike], mean: ArrayLike | None = None) -> WearMaps:
        """Predict the wear maps of some cases.

        Parameters
        ----------
        values : mapping of str to float or array
            The 14 sampled quantities in the units of `abradem.quantities`, broadcast to shape
            (n,). `abradem.surrogate.model.Surrogate.predict` checks such values.
        mean : array, shape (n,), optional
            Wear depth rate in the mean over the plate, mm/s, such as that of the surrogate of the
            rates; by default the one of this model.

        Returns
        -------
        WearMaps
        """
        columns = {
            name: np.atleast_1d(np.asarray(values[name], dtype=float)) for name in SAMPLED_NAMES
        }
        columns = dict(zip(columns, np.broadcast_arrays(*columns.values()), strict=True))
        numbers = wear_numbers(self.arrays, group_matrix(columns, self.jet), self.floor)
        rate = wear_scale(columns, self.jet)[:, None, None] * numbers
        if mean is not None:
            own = rate.mean(axis=(1, 2))
            rate = rate * (np.atleast_1d(mean) / own)[:, None, None]
        return WearMaps(rate, *self.centres())

    @property
    def floor(self) -> float:
        """f, a share of the mean over the plate."""
        return float(self.description["floor"])

    def centres(self) -> tuple[np.ndarray, np.ndarray]:
        """Centres of the elements along the slope and across, mm from the plate's centre."""
        plate = self.description["plate"]
        along, across = (
            MM_PER_M * plate[side] * ((np.arange(count) + 0.5) / count - 0.5)
            for side, count in zip(("length", "width"), self.arrays["mean_map"].shape, strict=True)
        )
        return along, across


def wear_numbers(arrays: Mapping[str, np.ndarray], groups: np.ndarray, floor: float) -> np.ndarray:
    """Wear numbers of the elements.

    Parameters
    ----------
    arrays : mapping of str to ndarray
        See `MapSurrogate`.
    groups : ndarray, shape (n, 10)
        From `abradem.surrogate.groups.group_matrix`.
    floor : float

    Returns
    -------
    ndarray, shape (n, nx, nz)
        Depth rate over the scale of the wear, dimensionless.
    """
    inside = np.clip(groups, arrays["group_low"], arrays["group_high"])
    z = (inside - arrays["group_mean"]) / arrays["group_scale"]
    found = second_order(z) @ arrays["coefficients"]
    return np.exp(found[:, 0])[:, None, None] * shapes(arrays, found[:, 1:], floor)


def shapes(arrays: Mapping[str, np.ndarray], modal: np.ndarray, floor: float) -> np.ndarray:
    """Shapes (n, nx, nz) of maps, of mean 1, from the coefficients (n, k) of their modes."""
    logs = arrays["mean_map"] + np.tensordot(modal, arrays["modes"], axes=1)
    worn = np.maximum(np.exp(logs) - floor, 0.0)
    mean = worn.mean(axis=(1, 2), keepdims=True)
    # A plate without wear anywhere has no shape; such a prediction is an even one.
    return np.where(mean > 0.0, worn / np.where(mean > 0.0, mean, 1.0), 1.0)


def second_order(z: np.ndarray) -> np.ndarray:
    """Terms 1, z_i and z_i z_j with i <= j of rows (n, p), shape (n, 1 + p + p (p + 1) / 2)."""
    first, second = np.triu_indices(z.shape[1])
    return np.column_stack([np.ones(len(z)), z, z[:, first] * z[:, second]])


def _fault(description: Any, arrays: Mapping[str, np.ndarray]) -> str | None:
    """Return the first fault of the two files, or None."""
    if not isinstance(description, Mapping) or description.get("kind") != KIND:
        return f"kind must be {KIND!r}"
    if description.get("groups") != list(GROUP_NAMES):
        return f"groups must be {', '.join(GROUP_NAMES)}"
    fields = [name for name in Jet._fields if name != "geometry"]
    if set(description.get("jet") or {}) - {"geometry"} != set(fields):
        return f"jet must have {', '.join(fields)}"
    if (description.get("target") or {}).get("measure") not in WEAR_MEASURES:
        return f"target.measure must be one of {', '.join(WEAR_MEASURES)}"
    if not _positive(description.get("floor")):
        return "floor must be a positive number"
    plate = description.get("plate") or {}
    if not all(_positive(plate.get(side)) for side in ("length", "width")):
        return "plate must have a length and a width above 0"
    groups = len(GROUP_NAMES)
    terms = 1 + groups + groups * (groups + 1) // 2
    modes = arrays.get("modes")
    if modes is None or modes.ndim != 3:
        return "modes must have shape (any, any, any)"
    expected = {
        **dict.fromkeys(("group_mean", "group_scale", "group_low", "group_high"), (groups,)),
        "coefficients": (terms, 1 + len(modes)),
        "mean_map": modes.shape[1:],
        "modes": modes.shape,
    }
    for name, shape in expected.items():
        array = arrays.get(name)
        if array is None or array.shape != shape:
            return f"{name} must have shape {shape}"
        if array.dtype.kind != "f" or not np.isfinite(array).all():
            return f"{name} must hold finite numbers"
    if not (arrays["group_scale"] > 0.0).all():
        return "group_scale must be positive"
    return None


def _positive(value: Any) -> bool:
    number = isinstance(value, int | float) and not isinstance(value, bool)
    return number and 0.0 < value < np.inf

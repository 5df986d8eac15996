"""The two files of a stored model: JSON, and the safetensors file next to it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from abradem.store.checksums import damage
from abradem.store.errors import TableError
from abradem.store.files import read_arrays, read_json
from abradem.surrogate.inputs import PredictionError


def stored_model(path: Path, absent: str) -> tuple[Any, dict[str, np.ndarray]]:
    """Read the description and the arrays of a model; what is in them is not checked.

    Parameters
    ----------
    path : Path
        The JSON file.
    absent : str
        What to do if a file does not exist, for the message.

    Raises
    ------
    PredictionError
        If a file is missing or damaged.
    """
    files = path, path.with_suffix(".safetensors")
    for file in files:
        if not file.exists():
            raise PredictionError(f"{file}: there is no such file; {absent}")
    for file in files:
        if line := damage(file):
            raise PredictionError(line)
    try:
        return read_json(files[0]), read_arrays(files[1])
    except TableError as error:
        raise PredictionError(str(error)) from None

"""abradem: wear data sets, models and figures from ranges of materials and geometry.

Importing the package is fast: numba, torch, scikit-learn and matplotlib are imported when used.
"""

from __future__ import annotations

import importlib

__version__ = "0.1.0"

_LAZY = {
    "Case": "abradem.dem",
    "Setup": "abradem.dem",
    "Material": "abradem.dem",
    "Interaction": "abradem.dem",
    "ContactModel": "abradem.dem",
    "SimulationResult": "abradem.dem",
    "CaseResult": "abradem.cases",
    "Impact": "abradem.dem",
    "simulate": "abradem.cases",
    "single_impact": "abradem.dem",
    "predict": "abradem.surrogate.model",
}

__all__ = ["__version__", *_LAZY]


def __getattr__(name: str):
    if name in _LAZY:
        return getattr(importlib.import_module(_LAZY[name]), name)
    raise AttributeError(f"module 'abradem' has no attribute {name!r}")


def __dir__():
    return sorted(__all__)

"""The discrete-element engine: particles poured on an inclined plate, and the wear they cause.

`model` defines the inputs and outputs. The compiled kernels are loaded at their first use.
"""

from __future__ import annotations

from abradem.dem import before_numba as before_numba
from abradem.dem.model import (
    Case,
    ContactModel,
    Impact,
    Interaction,
    Material,
    Setup,
    SimulationResult,
)

__all__ = [
    "Case",
    "ContactModel",
    "Impact",
    "Interaction",
    "Material",
    "Setup",
    "SimulationResult",
    "simulate",
    "single_impact",
]


def __getattr__(name: str):
    if name not in ("simulate", "single_impact"):
        raise AttributeError(f"module 'abradem.dem' has no attribute {name!r}")
    from abradem.dem import impact, simulation

    return {"simulate": simulation.simulate, "single_impact": impact.single_impact}[name]

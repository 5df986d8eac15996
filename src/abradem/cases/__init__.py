"""Cases of one's own: a simulation with its wear rates, maps and figures, and sweeps of many.

A study needs nothing of this; its stages write and read tables.
"""

from __future__ import annotations

from abradem.cases.results import CaseResult, DepthRate, simulate

__all__ = ["CaseResult", "DepthRate", "simulate"]

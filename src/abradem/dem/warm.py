"""Compile the kernels before the jobs of a study start: python -m abradem.dem.warm."""

from __future__ import annotations

from functools import cache

from abradem.dem import simulate, single_impact
from abradem.dem.model import STEPPINGS, Case, Setup

CASE = Case(6e9, 0.25, 2500, 77e9, 0.3, 7800, 0.5, 0.05, 0.45, 1e-9, 45.0, 0.0, 0.02, -5.0)


@cache
def load(stepping: str) -> None:
    """Run a short simulation with a stepping, or ``parallel`` with two threads, once per process.

    Loading the kernels takes half a second, compiling them half a minute.
    """
    if stepping == "parallel":
        simulate(CASE, Setup(duration=0.02, stepping="synchronous"), threads=2)
    else:
        simulate(CASE, Setup(duration=0.02, stepping=stepping))


def warm() -> None:
    """Run a short simulation with every stepping, and one impact."""
    for stepping in STEPPINGS:
        load(stepping)
    single_impact(CASE.particle, 0.01, CASE.plate, CASE.interaction, 3.9, 30.0)


if __name__ == "__main__":
    warm()

"""Compile the kernels before the jobs of a study start: python -m abradem.dem.warm [--geometry].

Without ``--geometry`` those of the plate are compiled, with it also those of surfaces.
"""

from __future__ import annotations

import sys
from functools import cache

from abradem.dem import simulate, single_impact
from abradem.dem.cache import compiling, is_compiled
from abradem.dem.model import STEPPINGS, Case, Setup
from abradem.dem.surface import standing_surface

CASE = Case(6e9, 0.25, 2500, 77e9, 0.3, 7800, 0.5, 0.05, 0.45, 1e-9, 45.0, 0.0, 0.02, -5.0)

SURFACE = standing_surface(
    [(-0.1, 0.0, -0.1), (-0.1, 0.0, 0.1), (0.1, 0.0, 0.1), (0.1, 0.0, -0.1)], [(0, 1, 2), (0, 2, 3)]
)


@cache
def load(stepping: str, on_surface: bool = False) -> None:
    """Run a short simulation with a stepping, once per process.

    Loading its kernels takes half a second, compiling them half a minute, and two minutes for a
    surface. Processes that need the same kernels at the same time wait for the first.

    Parameters
    ----------
    stepping : str
        Or ``parallel``, that of several threads, on the plate.
    on_surface : bool
        For a surface instead of the plate; the kernels of the two are separate.
    """
    surface = SURFACE if on_surface else None
    threads = 1
    if stepping == "parallel":
        setup, threads = Setup(duration=0.02, stepping="synchronous"), 2
    else:
        setup = Setup(duration=0.02, stepping=stepping, surface=surface)
    if is_compiled(stepping, on_surface):
        simulate(CASE, setup, threads=threads)
    else:
        with compiling():
            simulate(CASE, setup, threads=threads)


def warm(on_surface: bool = False) -> None:
    """Run a short simulation with every stepping, and one impact; with surfaces if asked for."""
    for stepping in STEPPINGS:
        for kind in (False, True)[: 1 + on_surface]:
            load(stepping, kind)
    single_impact(CASE.particle, 0.01, CASE.plate, CASE.interaction, 3.9, 30.0)


if __name__ == "__main__":
    warm(on_surface="--geometry" in sys.argv[1:])

"""Damping of the normal contact: the coefficient beta for a restitution e.

The normal force is ``4/3 E* sqrt(R*) d^{3/2} - 2 sqrt(5/6) beta sqrt(S_n m*) v_n`` with
``S_n = 2 E* sqrt(R* d)``. Scaled by the length and time of the Hertz contact, the equation of
motion is

    d'' = -d^{3/2} - sqrt(5) beta d^{1/4} d',    d(0) = 0, d'(0) = 1,

so the rebound depends on beta alone. Without a clip, the rebound is exactly e for the nominal
beta (Tsuji, Tanaka & Ishida 1992, Powder Technology 71:239). If attractive forces are clipped,
the contact ends earlier and the rebound is faster; with `exact_beta` it is e again.
"""

from __future__ import annotations

import functools
import math

from abradem.dem.cache import kernel

SMALLEST_RESTITUTION = 0.05
"""Smallest restitution allowed; below it the contact would be too stiff for the time step."""

_STEP = 1e-3
_LARGEST_BETA = 10.0


def nominal_beta(restitution: float) -> float:
    """Return -ln e / sqrt(ln^2 e + pi^2), the textbook damping (1); Tsuji et al. 1992."""
    if not 0.0 < restitution <= 1.0:
        raise ValueError(f"restitution = {restitution!r} is outside (0, 1]")
    log_e = math.log(restitution)
    return -log_e / math.hypot(log_e, math.pi)


@functools.lru_cache(maxsize=4096)
def exact_beta(restitution: float) -> float:
    """Return the damping (1) for which a never attractive contact rebounds at ``restitution``.

    The root of `clipped_rebound` (beta) = ``restitution`` is found by bisection.

    Raises
    ------
    ValueError
        If the restitution is outside [0.05, 1].
    """
    if not SMALLEST_RESTITUTION <= restitution <= 1.0:
        raise ValueError(
            f"restitution = {restitution!r} is outside [{SMALLEST_RESTITUTION}, 1]: "
            "the contact would be too stiff for the time step"
        )
    if restitution == 1.0:
        return 0.0
    low, high = 0.0, _LARGEST_BETA
    while high - low > 1e-12 * high:
        middle = 0.5 * (low + high)
        if clipped_rebound(middle) > restitution:
            low = middle
        else:
            high = middle
    return 0.5 * (low + high)


@kernel
def _acceleration(d, v, beta):
    root = math.sqrt(max(d, 0.0))
    return -d * root - math.sqrt(5.0) * beta * math.sqrt(root) * v


@kernel
def clipped_rebound(beta):
    """Return the rebound speed of the scaled impact that ends before the force attracts (RK4)."""
    h = _STEP
    d, v = 0.0, 1.0
    a1 = _acceleration(d, v, beta)
    while True:
        a2 = _acceleration(d + 0.5 * h * v, v + 0.5 * h * a1, beta)
        v3 = v + 0.5 * h * a2
        a3 = _acceleration(d + 0.5 * h * (v + 0.5 * h * a1), v3, beta)
        v4 = v + h * a3
        a4 = _acceleration(d + h * v3, v4, beta)
        d_next = d + h / 6.0 * (v + 2.0 * (v + 0.5 * h * a1) + 2.0 * v3 + v4)
        v_next = v + h / 6.0 * (a1 + 2.0 * a2 + 2.0 * a3 + a4)
        a_next = _acceleration(d_next, v_next, beta)
        if v_next < 0.0 and (a_next >= 0.0 or d_next <= 0.0):
            # The velocity has its extremum where the force is zero, so its slope is zero there.
            return -v_next
        d, v, a1 = d_next, v_next, a_next

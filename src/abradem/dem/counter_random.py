"""Counter-based random numbers: a pure function of (seed, particle, draw).

Each key is mixed with the finaliser of SplitMix64 (Steele, Lea & Flood 2014, OOPSLA). There is
no state, so the releases do not depend on how a run was divided or interrupted.
"""

from __future__ import annotations

import numpy as np

from abradem.dem.cache import kernel


@kernel(inline=True)
def _mixed(z):
    z = z + np.uint64(0x9E3779B97F4A7C15)
    z = (z ^ (z >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    z = (z ^ (z >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    return z ^ (z >> np.uint64(31))


@kernel(inline=True)
def uniform(seed, particle, draw):
    """Return a random number in [0, 1) with 53 random bits for three non-negative integers."""
    z = _mixed(np.uint64(seed))
    z = _mixed(z ^ np.uint64(particle))
    z = _mixed(z ^ np.uint64(draw))
    return np.float64(z >> np.uint64(11)) * (1.0 / 9007199254740992.0)

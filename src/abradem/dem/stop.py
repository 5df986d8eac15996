"""The stop rule: when the wear rate of a case is known well enough.

The batches of a short record that happens to be quiet have a small rate *and* a small standard
error. A rule that stops at the first small error therefore prefers low rates, and its intervals
hold less often than they state. Three conditions prevent this: enough particles, so that the rare
ones that wear most are in the record; a small error at two looks in a row, or one well below the
target; and looks that are not too frequent.
"""

from __future__ import annotations

import math

import numpy as np

from abradem.dem.model import Setup
from abradem.dem.steady import batch_means, steady_part

MAPS_PER_WINDOW = 10

CHECK_GROWTH = 1.1
"""Growth factor of the simulated time between two looks at a steady record: small enough to stop
early, large enough not to stop on a random fluctuation of the standard error."""

PARTICLES = 0.12
"""Least number of particles released in the steady part, times ``target_stderr`` squared: 300 for
an error of 2 %. It is the number at which the error reaches the target if the wear of single
particles scatters by 35 %. Some of a case are rare and wear much more than the others; a record
of fewer particles may hold none of them and then seems to be known better than it is."""

WELL_BELOW = 0.67
"""Share of the target below which one look is enough. The upper 95 % bound of a standard error
from 40 batches is 1.5 times its estimate, so the true one is then below the target."""


class SteadyPart:
    """The steady part of a record: its start, and its rate with the standard error.

    Parameters
    ----------
    time, worn, present : ndarray, shape (n,)
        Sample times, s, cumulative ``total`` wear, J, and number of particles present.
    window_maps : int
        Number of intervals between maps in the window.
    map_interval : float
        Time between maps, s.
    release_interval : float
        Time between two releases, s; 0 if they are not even.
    """

    def __init__(
        self, time, worn, present, window_maps: int, map_interval: float, release_interval: float
    ):
        # The start is moved to the next map.
        start = steady_part(time, worn, present, (window_maps + 1) * map_interval)
        self.settled = start.settled
        self.first_map = math.ceil(start.time / map_interval - 1e-9)
        self.last_map = self.first_map + window_maps
        self.start = self.first_map * map_interval
        self.window_end = self.last_map * map_interval
        found = batch_means(time, worn, self.start, release_interval=release_interval)
        known = found.batches > 0 and found.rate > 0.0
        self.rate = found.rate
        self.freedom = found.freedom
        self.relative_stderr = found.stderr / found.rate if known else math.inf

    def complete(self, maps: int) -> bool:
        """Whether the window after the start is inside a record with this number of maps."""
        return self.last_map < maps


class StopRule:
    """Looks at a growing record and says when the case may end.

    The outcome is a function of the samples alone, however they were computed.

    Parameters
    ----------
    setup : Setup
    sample_interval : float
        Time between samples as simulated, s.
    release_interval : float
        Time between two releases, s; 0 if they are not even. Then no number of particles is asked
        for.

    Attributes
    ----------
    map_samples, window_maps : int
        Samples between two maps, and intervals between maps in the window.
    map_interval : float
        Time between maps, s.
    next_look : int
        The sample at which `ends` is to be asked next.
    """

    def __init__(self, setup: Setup, sample_interval: float, release_interval: float):
        self.target = setup.target_stderr
        self.release_interval = release_interval
        self.map_samples = max(1, round(setup.window / MAPS_PER_WINDOW / sample_interval))
        self.map_interval = self.map_samples * sample_interval
        self.window_maps = max(1, round(setup.window / self.map_interval))
        self.least_time = PARTICLES / self.target**2 * release_interval
        self.next_look = max(1, math.ceil(setup.window / sample_interval - 1e-9))
        self._small_before = False

    def steady(self, time, worn, present) -> SteadyPart:
        """The steady part of a record, see `SteadyPart`."""
        return SteadyPart(
            time, worn, present, self.window_maps, self.map_interval, self.release_interval
        )

    def ends(self, time: np.ndarray, worn: np.ndarray, present: np.ndarray) -> bool:
        """Whether the case ends with this record, that is, at the sample ``next_look``.

        If not, ``next_look`` is moved on. The arrays are those of `SteadyPart`.
        """
        sample = len(time) - 1
        steady = self.steady(time, worn, present)
        look = max(sample + 1, math.ceil(sample * CHECK_GROWTH - 1e-9))
        complete = steady.settled and steady.complete(sample // self.map_samples + 1)
        if not steady.settled:
            look = min(look, sample + self.map_samples)
        elif not complete:
            # So far, only the rest of the window is missing.
            look = min(look, steady.last_map * self.map_samples)
        self.next_look = look
        small = complete and steady.relative_stderr <= self.target
        twice = small and self._small_before
        self._small_before = small
        enough = time[-1] - steady.start >= self.least_time
        return enough and (twice or (small and steady.relative_stderr <= WELL_BELOW * self.target))

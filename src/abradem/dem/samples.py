"""Many samples in one call: what a case is asked for between two looks at its stop rule.

A call of a kernel from Python costs more than the steps of a thin jet between two samples.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from abradem.dem import islands, synchronous
from abradem.dem.cache import kernel
from abradem.dem.energy import resident_energy
from abradem.dem.state import DONE, STOP_ENERGY_GAIN, STOP_NOT_FINITE, STOP_WEAR_NOT_FINITE, WORN

ENERGY_TOLERANCE = 0.02
"""Energy gained between two samples that ends a case, as a share of the energy put in."""


# Energy dissipated until the latest sample, J, and, if that ended the case, what was gained since
# the sample before, as a share of the energy put in.
BOOK = np.dtype([("dissipated", np.float64), ("gained", np.float64)])


class Record(NamedTuple):
    """What is noted at each sample.

    Attributes
    ----------
    worn : ndarray, shape (samples, 3)
        Wear of the plate by wear measure, W = 1, J.
    placed, present : ndarray of int, shape (samples,)
        Particles released, and those of them that were not removed yet.
    book : ndarray of BOOK, shape (1,)
    """

    worn: np.ndarray
    placed: np.ndarray
    present: np.ndarray
    book: np.ndarray


def make_record(samples: int) -> Record:
    """Return an empty record with room for ``samples`` after the beginning."""
    return Record(
        np.zeros((samples + 1, len(WORN))),
        np.zeros(samples + 1, np.int64),
        np.zeros(samples + 1, np.int64),
        np.zeros(1, BOOK),
    )


@kernel
def advance(problem, schedule, state, agenda, last_step):
    """Advance to lattice step ``last_step``, without an agenda by conventional stepping."""
    if agenda is None:
        return synchronous.advance(problem, schedule, state, last_step)
    return islands.advance(problem, schedule, state, agenda, last_step)


@kernel
def take_samples(problem, schedule, state, agenda, sample_steps, sample, last, record):
    """Go on from ``sample`` to ``last``; return the last one reached and how that ended.

    Samples are ``sample_steps`` lattice steps apart. Calling it in pieces gives the same bits as
    calling it once.
    """
    tally = state.tally[0]
    while sample < last:
        outcome = advance(problem, schedule, state, agenda, (sample + 1) * sample_steps)
        if outcome == DONE:
            outcome = _guard(problem, state, record.book[0])
        if outcome != DONE:
            return sample, outcome
        sample += 1
        # In the order of WORN.
        record.worn[sample, 0] = tally.worn_total
        record.worn[sample, 1] = tally.worn_sliding
        record.worn[sample, 2] = tally.worn_friction
        record.placed[sample] = tally.placed
        record.present[sample] = tally.placed - tally.removed
    return sample, DONE


@kernel
def _guard(problem, state, book):
    """Check that positions are numbers and that no energy was gained since the last sample."""
    tally = state.tally[0]
    resident = resident_energy(problem, state)
    if not (math.isfinite(resident) and math.isfinite(tally.energy_out)):
        return STOP_NOT_FINITE
    worn = (tally.worn_total, tally.worn_sliding, tally.worn_friction)
    if not (math.isfinite(worn[0]) and math.isfinite(worn[1]) and math.isfinite(worn[2])):
        return STOP_WEAR_NOT_FINITE
    dissipated = tally.energy_in - tally.energy_out - resident
    gained = book.dissipated - dissipated
    book.dissipated = dissipated
    if gained > ENERGY_TOLERANCE * max(tally.energy_in, 0.0) and gained > 0.0:
        book.gained = gained / tally.energy_in
        return STOP_ENERGY_GAIN
    return DONE

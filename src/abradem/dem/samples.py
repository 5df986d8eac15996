"""Several samples in one kernel call, between two evaluations of the stop rule.

A kernel call from Python costs more than the steps of a dilute jet between two samples.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from abradem.dem import islands, synchronous
from abradem.dem.cache import kernel
from abradem.dem.energy import energy_present
from abradem.dem.state import DONE, STOP_ENERGY_GAIN, STOP_NOT_FINITE, STOP_WEAR_NOT_FINITE, WORN

ENERGY_TOLERANCE = 0.02
"""Energy gain between two samples that ends a case, as a share of the energy that could move."""

SLOWEST = 1e-6
"""Speed, m/s, whose kinetic energy per released particle is no gain: it does not wear."""

ROUNDING = 1e-12
"""Share of the heights of the set-up by which rounding may seem to lift each released particle."""


# At the latest sample, J: energy dissipated so far, energy that moves (kinetic and elastic), and
# kinetic energy of the particles released so far and removed so far. If an energy gain ended the
# case: the gain since the previous sample, as a share of the energy that could move.
BALANCE = np.dtype(
    [(name, np.float64) for name in ("dissipated", "moving", "released", "removed", "gained")]
)


class Record(NamedTuple):
    """Values recorded at each sample.

    Attributes
    ----------
    worn : ndarray, shape (samples, 3)
        Cumulative wear of the plate by wear measure, W = 1, J.
    placed, present : ndarray of int, shape (samples,)
        Number of particles released so far, and number of particles present.
    balance : ndarray of BALANCE, shape (1,)
        Energy balance at the latest sample.
    """

    worn: np.ndarray
    placed: np.ndarray
    present: np.ndarray
    balance: np.ndarray


def make_record(samples: int) -> Record:
    """Return an empty record for ``samples`` samples after the one at time 0."""
    return Record(
        np.zeros((samples + 1, len(WORN))),
        np.zeros(samples + 1, np.int64),
        np.zeros(samples + 1, np.int64),
        np.zeros(1, BALANCE),
    )


@kernel
def advance(problem, schedule, state, agenda, last_step):
    """Advance to lattice step ``last_step``; conventional stepping if ``agenda`` is None."""
    if agenda is None:
        return synchronous.advance(problem, schedule, state, last_step)
    return islands.advance(problem, schedule, state, agenda, last_step)


@kernel
def take_samples(problem, schedule, state, agenda, sample_steps, sample, last, record):
    """Continue from ``sample`` to ``last``; return the last sample reached and the outcome.

    Samples are ``sample_steps`` lattice steps apart. Several calls give bitwise the same result
    as a single call.
    """
    tally = state.tally[0]
    while sample < last:
        outcome = advance(problem, schedule, state, agenda, (sample + 1) * sample_steps)
        if outcome == DONE:
            outcome = _guard(problem, state, record.balance[0])
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
def _guard(problem, state, balance):
    """Check that positions and wear are finite and that no energy was gained since last time.

    What is gained is compared with the energy that could move since the last sample: the kinetic
    and elastic energy at that time, the kinetic energy of the particles released since, and the
    potential energy that was set free. So the guard depends neither on what was put in or removed
    earlier nor on the level that heights are measured from.
    """
    tally = state.tally[0]
    resident, moving = energy_present(problem, state)
    if not (math.isfinite(resident) and math.isfinite(tally.energy_out)):
        return STOP_NOT_FINITE
    worn = (tally.worn_total, tally.worn_sliding, tally.worn_friction)
    if not (math.isfinite(worn[0]) and math.isfinite(worn[1]) and math.isfinite(worn[2])):
        return STOP_WEAR_NOT_FINITE
    dissipated = tally.energy_in - tally.energy_out - resident
    gained = balance.dissipated - dissipated
    before = balance.moving + tally.kinetic_in - balance.released
    # By the balance of energy: that before, and the potential energy set free since.
    after = moving + tally.kinetic_out - balance.removed - gained
    could_move = max(before, after, 0.0)
    balance.dissipated = dissipated
    balance.moving = moving
    balance.released, balance.removed = tally.kinetic_in, tally.kinetic_out
    height = abs(problem.patch_height) + abs(problem.removal_height) + problem.radius
    nothing = problem.mass * (0.5 * SLOWEST**2 + ROUNDING * problem.gravity * height)
    if gained > ENERGY_TOLERANCE * could_move + tally.placed * nothing:
        balance.gained = gained / max(could_move, tally.placed * nothing)
        return STOP_ENERGY_GAIN
    return DONE

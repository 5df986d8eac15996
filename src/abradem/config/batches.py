"""Batches of cases: the cases that one job simulates."""

from __future__ import annotations

import math

JOBS_PER_BLOCK = 10
"""Number of jobs per block with ``cases_per_job: auto``: enough to keep a few cores busy, and few
enough that starting them takes less than a tenth of the time of thousands of cases."""


MOST_CASES_PER_JOB = 100
"""Largest number of cases per job with ``auto``; limits the loss by an interruption."""


def cases_per_job(setting: str | int, cases_per_block: int) -> int:
    """Return the number of cases per job.

    ``auto`` divides a block into about `JOBS_PER_BLOCK` jobs with at most `MOST_CASES_PER_JOB`
    cases each, because starting a job takes seconds. The rule depends only on the size of a block,
    so the batches stay the same with more blocks or on another machine.
    """
    if setting != "auto":
        return min(int(setting), cases_per_block)
    return min(MOST_CASES_PER_JOB, math.ceil(cases_per_block / JOBS_PER_BLOCK))


def batches_of_block(cases_per_block: int, setting: str | int = "auto") -> list[tuple[int, int]]:
    """Return the first case and the last case plus one of every batch, counted in the block.

    Parameters
    ----------
    cases_per_block : int
    setting : "auto" or int
        Cases per job, see `cases_per_job`.
    """
    step = cases_per_job(setting, cases_per_block)
    return [
        (start, min(start + step, cases_per_block)) for start in range(0, cases_per_block, step)
    ]

"""How many cases one job simulates."""

from __future__ import annotations

import math

JOBS_PER_BLOCK = 10
"""Jobs that ``cases_per_job: auto`` makes of a block: enough to keep a few cores busy, few enough
for their starts to stay below a tenth of the time of thousands of cases."""


MOST_CASES_PER_JOB = 100
"""Most cases of a job that ``cases_per_job: auto`` allows: what an interruption can cost."""


def cases_per_job(setting: str | int, cases_per_block: int) -> int:
    """Cases of one job.

    ``auto`` makes about `JOBS_PER_BLOCK` jobs of a block, with `MOST_CASES_PER_JOB` cases at
    most: starting a job costs seconds. The rule looks at the block alone, so that neither more
    blocks nor another machine cuts the batches differently.
    """
    if setting != "auto":
        return min(int(setting), cases_per_block)
    return min(MOST_CASES_PER_JOB, math.ceil(cases_per_block / JOBS_PER_BLOCK))


def batches_of_block(cases_per_block: int, setting: str | int = "auto") -> list[tuple[int, int]]:
    """First and last-plus-one case of every batch, counted within the block.

    Parameters
    ----------
    cases_per_block : int
    setting : "auto" or int
        Cases of one job, see `cases_per_job`.
    """
    step = cases_per_job(setting, cases_per_block)
    return [
        (start, min(start + step, cases_per_block)) for start in range(0, cases_per_block, step)
    ]

"""Estimate of the run time of a study before it starts."""

from __future__ import annotations

import os

from abradem.config.declaration import Config
from abradem.config.geometry import geometry_ranges
from abradem.config.table_keys import UNKNOWN
from abradem.config.values import sampled_ranges, setup_dict
from abradem.dem.cache import compiling_words, is_compiled

SECONDS_PER_JOB = 2.5
"""Start-up time of a job, s: interpreter, imports, loading of compiled code."""

_LOOKED_AT = 1000
"""Largest number of cases whose time is estimated; further cases are assumed to be similar."""


def estimate(config: Config, cores: int | None = None) -> str:
    """One line on what a run will do: cases, jobs and the approximate run time.

    Parameters
    ----------
    config : Config
    cores : int, optional
        Number of cores; by default those of this machine.

    Returns
    -------
    str
        The time is estimated by `abradem.sampling.cost.case_seconds`. If the engine has not been
        compiled on this machine, the line says so, as this takes longer than a small study.
    """
    from abradem.sampling.cost import case_seconds
    from abradem.sampling.draw import block_cases

    if config.calibration.table is not None:
        from abradem.running.trial_setups import search_rungs

        rungs = search_rungs(config)
        of = ", ".join(str(rung.trials) for rung in rungs)
        return (
            f"{config.study}: calibration to {config.calibration.table}, {of} set-ups in "
            f"{_count(len(rungs), 'rung')}, a job each"
        )
    if config.dataset.external is not None:
        line = f"{config.study}: learning from {config.dataset.external}, nothing is simulated"
        unknown = [key for key in ("jet", "rate") if getattr(config.dataset, key) == UNKNOWN]
        if unknown:
            keys = " and ".join(f"dataset.{key}" for key in unknown)
            line += f"; {keys} unknown, write stated if the study file says what they are"
        return line
    cores = cores or os.cpu_count() or 1
    sampling = config.sampling
    jobs = config.jobs
    size = min(sampling.cases_per_block, _LOOKED_AT)
    blocks = min(sampling.blocks, -(-_LOOKED_AT // size))
    ranges, setup = sampled_ranges(config), setup_dict(config)
    looked_at = [
        case_seconds(
            block_cases(
                config.seed,
                block,
                size,
                sampling.method,
                ranges,
                geometry=geometry_ranges(config),
            ),
            setup,
        )
        for block in range(blocks)
    ]
    each = sum(spent.sum() for spent in looked_at) / (blocks * size)
    # The most expensive batch starts first, but cores cannot share it.
    longest = max(spent[start:stop].sum() for spent in looked_at for start, stop in config.batches)
    # Only crowds use the threads of a job, so that they are taken to gain nothing.
    at_once = min(max(cores // config.threads, 1), jobs)
    shared = (config.cases * each + jobs * SECONDS_PER_JOB) / at_once
    seconds = max(shared, longest + SECONDS_PER_JOB)
    needed = config.simulation.stepping, setup.get("geometry") is not None
    compiles = f", after the engine is compiled, {compiling_words(needed[1])}"
    return (
        f"{config.study}: {_count(config.cases, 'case')} in {_count(sampling.blocks, 'block')}, "
        f"{_count(jobs, 'simulation job')}, simulated in about {_duration(seconds)} on "
        f"{_count(cores, 'core')}" + ("" if is_compiled(*needed) else compiles)
    )


def _count(number: int, noun: str) -> str:
    return f"{number} {noun}" if number == 1 else f"{number} {noun}s"


def _duration(seconds: float) -> str:
    if seconds < 90.0:
        return f"{max(5, 5 * round(seconds / 5))} s"
    if seconds < 5400.0:
        return f"{seconds / 60.0:.0f} min"
    return f"{seconds / 3600.0:.1f} h"

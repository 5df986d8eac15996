import json
import os
import re
import sys
from functools import cache
from pathlib import Path

from abradem.config import (
    ConfigError,
    load_config,
    sampled_ranges,
    setup_dict,
    to_yaml,
    typical_case,
)
from abradem.cost import shard_seconds
from abradem.figures.listing import GROUP_OF
from abradem.locks import Lock
from abradem.progress import Monitor, Shard
from abradem.provenance import STEPS, code_hash, step_hash, versions
from abradem.runtimes import run_times


def file_of_workflow(path):
    """A file of this workflow as rules name it: relative where the run is in its folder."""
    full = Path(HOME, path)
    return str(
        full.relative_to(Path.cwd()) if full.is_relative_to(Path.cwd()) else full
    )


try:
    # The overlays of the command line come last, as they were merged. A module has its
    # configuration from the workflow that imports it, whose files are another's.
    CONFIG = load_config(
        config,
        (
            ()
            if IN_MODULE
            else sorted(
                workflow.configfiles,
                key=lambda path: path in workflow.overwrite_configfiles,
            )
        ),
        "config of the module" if IN_MODULE else "command line",
    )
except ConfigError as error:
    sys.exit(str(error))

RESULTS = f"results/{CONFIG.study}"
LOGS = f"{RESULTS}/logs"
SETUP = setup_dict(CONFIG)
# Or learned from a table that someone else made.
SIMULATED = CONFIG.dataset.external is None

# Hash of all code that a step uses, a parameter of its rule: an edit reruns the step.
CODE = {step: step_hash(step, Path(HOME, "workflow/scripts")) for step in STEPS}

BLOCKS = range(CONFIG.sampling.blocks)
SHARDS = CONFIG.shards


def shard_paths(pattern):
    """Paths of a table of all shards of all blocks."""
    return [
        pattern.format(block=f"{block:03d}", shard=f"{shard:03d}")
        for block in BLOCKS
        for shard in range(len(SHARDS))
    ]


@cache
def seconds_of_shards(block):
    """Guessed computing times of the shards of a block; nothing but an order follows."""
    # With SciPy, whose import only a run with simulations has to wait for.
    from abradem.sampling import block_cases

    drawn = block_cases(
        CONFIG.seed,
        block,
        CONFIG.sampling.cases_per_block,
        CONFIG.sampling.method,
        sampled_ranges(CONFIG),
    )
    return shard_seconds(drawn, SETUP, SHARDS)


def seconds_of_shard(wildcards):
    """Guessed computing time of a shard, s."""
    return seconds_of_shards(int(wildcards.block))[int(wildcards.shard)]


def shards_with(cases, pattern):
    """Paths of a table of the shards that hold certain cases of the study."""
    size = CONFIG.sampling.cases_per_block
    places = {
        (case // size, shard)
        for case in cases
        for shard, (start, stop) in enumerate(SHARDS)
        if start <= case % size < stop
    }
    paths = [
        pattern.format(block=f"{block:03d}", shard=f"{shard:03d}")
        for block, shard in sorted(places)
    ]
    return list(dict.fromkeys(paths))


# What a job asks a cluster for, where that is not the profile's default: docs/cluster.md has the
# measurements. A retry asks for more. Minutes of a shard leave room for one case that takes hours.
def growing(first):
    """A resource that grows with the attempts of a job."""
    return lambda wildcards, attempt: first * attempt


SHARD_MB = 1500
SHARD_MINUTES = 180 + max(stop - start for start, stop in SHARDS)
LEARNING_MB = 4000
LEARNING_MINUTES = 240

FORMATS = CONFIG.figures.formats


def beside(output, name):
    """A folder of the study that holds ``<folder>/<output>``; a module's may have a prefix."""
    return str(Path(output).parents[1] / name)


VERIFICATION_CHECKS = Path("results/verification/checks.parquet")
VERIFICATION_MADE = VERIFICATION_CHECKS.is_file()
# As benchmarks/cost.py writes them.
SPEED_TABLES = [
    Path("results/benchmarks/counts.csv"),
    Path("results/benchmarks/times.csv"),
]
SPEED_MADE = all(path.is_file() for path in SPEED_TABLES)


def figure_file(name, label, suffix):
    """The file of a figure in one format, as the report shows it."""
    return report(
        f"{RESULTS}/figures/{name}.{suffix}",
        caption=f"../report/{name}.rst",
        category="Figures",
        subcategory=GROUP_OF[name],
        labels={"figure": label, "format": suffix},
    )


def figure_files(name, label):
    """The files of a figure, one for each format."""
    return [figure_file(name, label, suffix) for suffix in FORMATS]


def latex_file(name):
    """A file to be included in a LaTeX text, as the report offers it."""
    return report(
        f"{RESULTS}/latex/{name}.tex",
        caption="../report/latex.rst",
        category="LaTeX",
        labels={"file": name},
    )


def part_files(part, suffix):
    """Files of the tables of a part of the verification study, by their names."""
    return {
        table: f"{VERIFIED}/tables/{part}_{table}.{suffix}" for table in PARTS[part]
    }


def to_simulate(jobs):
    """The shards, as the monitor knows them, among the jobs of a run."""
    return {
        job.output.runs: Shard(
            cases=len(range(*SHARDS[int(job.wildcards.shard)])),
            runs=Path(job.output.runs),
            finished=Path(job.params.finished),
            work=seconds_of_shard(job.wildcards),
        )
        for job in jobs
        if job.rule.name == "simulate"
    }


def lift_rate_limit(scheduler):
    """Start jobs as they come, unless the user set a limit of their own.

    To start no more than 100 jobs in a second, Snakemake 9 looks at all that wait once a second,
    and once more each second for every job that has ended: minutes in an hour of two cores.
    """
    limiter = getattr(scheduler, "job_rate_limiter", None)
    if limiter is not None and (limiter.max_jobs, limiter.timespan) == (100, 1):
        scheduler.job_rate_limiter = None


# In the place of Snakemake's own locks, which a killed run leaves behind.
RUN_LOCK = Lock(Path(".snakemake", f"abradem-{CONFIG.study}.lock"))

MONITOR = Monitor(CONFIG.cases, Path(RESULTS, ".finished"))

# What the report's overview says; it is there once the results are.
SUMMARY = Path(RESULTS, "summary.json")
VERSIONS = Path(RESULTS, "versions.json")
config["summary"] = json.loads(SUMMARY.read_text()) if SUMMARY.is_file() else {}
config["recorded"] = json.loads(VERSIONS.read_text()) if VERSIONS.is_file() else {}
config["run_times"] = run_times(Path(RESULTS, "benchmarks"))
config["resolved"] = CONFIG.model_dump(mode="json")


wildcard_constraints:
    block=r"\d+",
    shard=r"\d+",
    case=r"\d+",

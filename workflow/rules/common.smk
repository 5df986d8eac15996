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
from abradem.figures.catalogue import FIGURES, SIMULATIONS
from abradem.report.tables import TABLES
from abradem.running.code_hash import files_hash, step_hash
from abradem.running.progress import BatchOfCases, Monitor
from abradem.running.provenance import versions
from abradem.running.run_times import run_times
from abradem.sampling.cost import batch_seconds
from abradem.store.files import read_json
from abradem.store.locks import Lock


def file_of_workflow(path):
    """A file of this workflow as rules name it: relative where the run is in its folder."""
    full = Path(HOME, path)
    return str(
        full.relative_to(Path.cwd()) if full.is_relative_to(Path.cwd()) else full
    )


try:
    # The override files of the command line come last, as they were merged. A module has its
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

# Hashes of all code that a rule uses, by its script; a parameter of the rule.
CODE = {}


def code_of(script, *modules):
    """Hash of the code that a script reaches, also by the modules it is given: an edit reruns."""
    name = " ".join([script, *modules])
    if name not in CODE:
        CODE[name] = step_hash(Path(HOME, f"workflow/scripts/{script}.py"), modules)
    return CODE[name]


BLOCKS = range(CONFIG.sampling.blocks)
BATCHES = CONFIG.batches


def batch_paths(pattern):
    """Paths of a table of all batches of all blocks."""
    return [
        pattern.format(block=f"{block:03d}", batch=f"{batch:03d}")
        for block in BLOCKS
        for batch in range(len(BATCHES))
    ]


@cache
def seconds_of_batches(block):
    """Guessed computing times of the batches of a block; nothing but an order follows."""
    # With SciPy, whose import only a run with simulations has to wait for.
    from abradem.sampling.draw import block_cases

    drawn = block_cases(
        CONFIG.seed,
        block,
        CONFIG.sampling.cases_per_block,
        CONFIG.sampling.method,
        sampled_ranges(CONFIG),
    )
    return batch_seconds(drawn, SETUP, BATCHES)


def seconds_of_batch(wildcards):
    """Guessed computing time of a batch, s."""
    return seconds_of_batches(int(wildcards.block))[int(wildcards.batch)]


def batches_with(cases, pattern):
    """Paths of a table of the batches that hold certain cases of the study."""
    size = CONFIG.sampling.cases_per_block
    places = {
        (case // size, batch)
        for case in cases
        for batch, (start, stop) in enumerate(BATCHES)
        if start <= case % size < stop
    }
    paths = [
        pattern.format(block=f"{block:03d}", batch=f"{batch:03d}")
        for block, batch in sorted(places)
    ]
    return list(dict.fromkeys(paths))


# What a job asks a cluster for, where that is not the profile's default: docs/cluster.md has the
# measurements. A retry asks for more. Minutes of a batch leave room for one case that takes hours.
def growing(first):
    """A resource that grows with the attempts of a job."""
    return lambda wildcards, attempt: first * attempt


BATCH_MB = 1500
BATCH_MINUTES = 180 + max(stop - start for start, stop in BATCHES)
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


def figure_file(name, suffix):
    """The file of a figure in one format, as the report shows it."""
    entry = FIGURES[name]
    return report(
        f"{RESULTS}/figures/{name}.{suffix}",
        caption="../report/caption.rst",
        category="Figures",
        subcategory=entry.group,
        labels={"figure": entry.label, "format": suffix},
    )


def figure_files(name):
    """The files of a figure, one for each format."""
    return [figure_file(name, suffix) for suffix in FORMATS]


def drawn_as(name):
    """Parameters of a figure's rule: what draws it, its caption, and the hash of its code."""
    entry = FIGURES[name]
    return {
        "draw": entry.draw,
        "caption": entry.full_caption,
        "code": code_of("figures/figure", entry.module),
    }


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
    """The batches, as the monitor knows them, among the jobs of a run."""
    return {
        job.output.runs: BatchOfCases(
            cases=len(range(*BATCHES[int(job.wildcards.batch)])),
            runs=Path(job.output.runs),
            finished=Path(job.params.finished),
            work=seconds_of_batch(job.wildcards),
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
config["summary"] = read_json(SUMMARY) if SUMMARY.is_file() else {}
config["recorded"] = read_json(VERSIONS) if VERSIONS.is_file() else {}
config["run_times"] = run_times(Path(RESULTS, "benchmarks"))
config["resolved"] = CONFIG.model_dump(mode="json")


wildcard_constraints:
    block=r"\d+",
    batch=r"\d+",
    case=r"\d+",

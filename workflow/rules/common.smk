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
from abradem.dataset.variation import nothing_varies
from abradem.figures.catalogue import FIGURES, SIMULATIONS
from abradem.report.tables import TABLES
from abradem.running.code_hash import files_hash, step_hash
from abradem.running.progress import BatchOfCases, Monitor
from abradem.running.provenance import versions
from abradem.running.run_times import run_times
from abradem.store.files import read_json
from abradem.store.locks import Lock


def file_of_workflow(path):
    """Path of a file of this workflow; relative if the run is in the folder of the workflow."""
    full = Path(HOME, path)
    return str(
        full.relative_to(Path.cwd()) if full.is_relative_to(Path.cwd()) else full
    )


try:
    # Override files of the command line come last, in the order in which they were merged. A
    # module gets its configuration from the importing workflow, not from files of its own.
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
# False if the models are trained on an external table.
SIMULATED = CONFIG.dataset.external is None

# Why nothing can be learned, or "". The data set alone can still be made: it holds repetitions of
# one case.
NOTHING_VARIES = (
    "sampling.ranges: every quantity is held fixed, so nothing can be learned (allowed: a lower "
    "and an upper bound that differ for at least one; `snakemake dataset` makes the data set)"
    if SIMULATED and nothing_varies(sampled_ranges(CONFIG))
    else ""
)

# Hashes of the code that rules depend on, by script; they are parameters of the rules.
CODE = {}


def code_of(script, *modules):
    """Hash of the code that a script depends on, including modules passed to it by name."""
    name = " ".join([script, *modules])
    if name not in CODE:
        CODE[name] = step_hash(Path(HOME, f"workflow/scripts/{script}.py"), modules)
    return CODE[name]


BLOCKS = range(CONFIG.sampling.blocks)
BATCHES = CONFIG.batches


def batch_paths(pattern):
    """Paths of the tables of all batches of all blocks."""
    return [
        pattern.format(block=f"{block:03d}", batch=f"{batch:03d}")
        for block in BLOCKS
        for batch in range(len(BATCHES))
    ]


@cache
def seconds_of_batches(block):
    """Estimated computing times (s) of the batches of a block; they only set priorities."""
    # Imported here, as pandas and SciPy load slowly and only runs with simulations need them.
    from abradem.sampling.cost import batch_seconds
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
    """Estimated computing time of a batch, s."""
    return seconds_of_batches(int(wildcards.block))[int(wildcards.batch)]


def batches_with(cases, pattern):
    """Paths of the tables of the batches that contain certain cases of the study."""
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


# Resources that a job requests on a cluster if they differ from the defaults of the profile; see
# docs/cluster.md for measurements. Retries request more. The run time of a batch allows for one
# case that takes hours.
def growing(first):
    """A resource proportional to the number of attempts of a job."""
    return lambda wildcards, attempt: first * attempt


BATCH_MB = 1500
BATCH_MINUTES = 180 + max(stop - start for start, stop in BATCHES)
LEARNING_MB = 4000
LEARNING_MINUTES = 240

FORMATS = CONFIG.figures.formats


def beside(output, name):
    """A path in the results of the study of an output, also if a module has a path prefix."""
    return str(Path(output).parents[1] / name)


VERIFICATION_CHECKS = Path("results/verification/checks.parquet")
VERIFICATION_MADE = VERIFICATION_CHECKS.is_file()
# Written by benchmarks/cost.py.
SPEED_TABLES = [
    Path("results/benchmarks/counts.csv"),
    Path("results/benchmarks/times.csv"),
]
SPEED_MADE = all(path.is_file() for path in SPEED_TABLES)


def module_of(name):
    """The module that trains a model, and the hash of the code behind it."""
    source = f"abradem.learning.baselines.{name}"
    return {"module": source, "code": code_of("baselines/baseline", source)}


def is_made(name):
    """Whether a figure is made: some need simulations or results of other studies."""
    needs = {"verification": VERIFICATION_MADE, "speed": SPEED_MADE}
    return needs.get(name, SIMULATED or FIGURES[name].group != SIMULATIONS) and (
        SIMULATED or name != "setup"
    )


def figure_file(name, suffix):
    """The file of a figure in one format, with its entry in the report."""
    entry = FIGURES[name]
    return report(
        f"{RESULTS}/figures/{name}.{suffix}",
        caption="../report/caption.rst",
        category="Figures",
        subcategory=entry.group,
        labels={"figure": entry.label, "format": suffix},
    )


def figure_files(name):
    """The files of a figure, one per format."""
    return [figure_file(name, suffix) for suffix in FORMATS]


def drawn_as(name):
    """Parameters of the rule of a figure (drawing function, caption, hash of the code)."""
    entry = FIGURES[name]
    return {
        "draw": entry.draw,
        "caption": entry.full_caption,
        "code": code_of("figures/figure", entry.module),
    }


def latex_file(name):
    """A file for a LaTeX text, with its entry in the report."""
    return report(
        f"{RESULTS}/latex/{name}.tex",
        caption="../report/latex.rst",
        category="LaTeX",
        labels={"file": name},
    )


def part_files(part, suffix):
    """Files of the tables of a part of the verification study, by name."""
    return {
        table: f"{VERIFIED}/tables/{part}_{table}.{suffix}" for table in PARTS[part]
    }


def part(name, source=None):
    """Parameters of the rule of a part (tables, module, hash of the code)."""
    source = f"abradem.verification.{source or name}"
    return {
        "tables": PARTS[name],
        "module": source,
        "code": code_of("verification/part", source),
    }


def to_simulate(jobs):
    """The batches to be simulated by the jobs of a run, for the progress monitor."""
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
    """Remove the default rate limit of job starts, unless the user has set one.

    To limit the rate to 100 jobs per second, Snakemake 9 checks all waiting jobs once a second,
    and once more each second for every finished job. This costs minutes per hour on two cores.
    """
    limiter = getattr(scheduler, "job_rate_limiter", None)
    if limiter is not None and (limiter.max_jobs, limiter.timespan) == (100, 1):
        scheduler.job_rate_limiter = None


# Replaces the locks of Snakemake, which a killed run leaves behind.
RUN_LOCK = Lock(Path(".snakemake", f"abradem-{CONFIG.study}.lock"))

MONITOR = Monitor(CONFIG.cases, Path(RESULTS, ".finished"))

# Content of the overview of the report, available once the results exist.
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

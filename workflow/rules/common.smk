import json
import os
import re
import sys
from functools import cache
from pathlib import Path

from abradem.config import (
    ConfigError,
    geometry_ranges,
    load_config,
    read_config,
    sampled_ranges,
    rate_options,
    setup_dict,
    target_dict,
    contacts_of,
    jet_is_known,
    to_yaml,
    typical_case,
)
from abradem.config.materials import PARTICLE_MATERIALS, preset
from abradem.dataset.variation import nothing_varies
from abradem.figures.captions import caption_in_rst
from abradem.figures.catalogue import (
    ALL_MODELS,
    CALIBRATION,
    FIGURES,
    PHYSICAL as PHYSICAL_FIGURES,
    SIMULATIONS,
    SURFACE,
)
from abradem.publish.description import LICENCE
from abradem.quantities import wear_parts
from abradem.report.page_files import EXPLORER_FILES, FRAME_FILES, SCENE_FILES
from abradem.report.tables import TABLES
from abradem.running.code_hash import files_hash, step_hash
from abradem.running.memory import killed_for_memory, memory_kills
from abradem.running.progress import BatchOfCases, Monitor
from abradem.running.provenance import versions
from abradem.running.run_times import run_times
from abradem.store.checksums import damage
from abradem.store.files import (
    TableError,
    read_json,
    why_no_folder,
    why_not_written,
)
from abradem.store.locks import lock_of_study
from abradem.words.escaping import data_for_rst
from abradem.words.labels import SURFACES


def file_of_workflow(path):
    """Path of a file of this workflow; relative if the run is in the folder of the workflow."""
    full = Path(HOME, path)
    return str(
        full.relative_to(Path.cwd()) if full.is_relative_to(Path.cwd()) else full
    )


def origins():
    """The files and the entries of the command line from which the configuration is read."""
    if IN_MODULE:
        return [], []
    settings = workflow.config_settings
    # Override files of the command line come last, in the order in which they are merged.
    overrides = workflow.overwrite_configfiles
    files = [] if settings.replace_workflow_config else workflow.configfiles
    first = [path for path in files if path not in overrides]
    return [*first, *overrides], settings.config_args or ()


def configuration():
    """The configuration, from the texts of the files and of the command line.

    They are read again, as Snakemake turns some words into other values without a message. A
    module gets its configuration from the importing workflow.
    """
    if IN_MODULE:
        return load_config(config, "config of the module")
    files, entries = origins()
    return read_config(*files, command_line=entries)


try:
    CONFIG = configuration()
except ConfigError as error:
    sys.exit(str(error))

RESULTS = f"results/{CONFIG.study}"
LOGS = f"{RESULTS}/logs"
if reason := why_no_folder(RESULTS):
    sys.exit(reason)
SETUP = setup_dict(CONFIG)
# What the models predict, as arguments of abradem.words.wear.WearTarget.
TARGET = target_dict(CONFIG)
MEASURE, _ = wear_parts(TARGET["name"])
# False if the models are trained on an external table.
SIMULATED = CONFIG.dataset.external is None
# True if the study is a search for the set-up that explains a table.
CALIBRATES = CONFIG.calibration.table is not None

# True if the particles wear another surface than the plate: models and the figures of the plate
# are left out, and geometry.smk adds its own results.
WEARS_SURFACE = SIMULATED and CONFIG.simulation.geometry.kind != "plate"

# What the particles wear, in words.
WORN_SURFACE = SURFACES[CONFIG.simulation.geometry.kind if SIMULATED else "plate"]
# Smallest number of cases of a geometry from which models are trained: with fewer the test rows of
# a split are less than four. Smaller studies end with their cells and parts.
FEWEST_LEARNED = 20
LEARNS_SURFACE = (
    WEARS_SURFACE
    and not CALIBRATES
    and CONFIG.cases >= FEWEST_LEARNED
    and not nothing_varies({**sampled_ranges(CONFIG), **geometry_ranges(CONFIG)})
)
# True if there are simulations of the plate: maps, replicates and their figures are of it alone.
ON_PLATE = SIMULATED and not WEARS_SURFACE

# Why nothing can be learned, or "". The data set alone can still be made: it holds repetitions of
# one case.
NOTHING_VARIES = (
    "sampling.ranges: every quantity is held fixed, so nothing can be learned (allowed: a lower "
    "and an upper bound that differ for at least one; `snakemake dataset` makes the data set)"
    if SIMULATED
    and not CALIBRATES
    and not WEARS_SURFACE
    and nothing_varies(sampled_ranges(CONFIG))
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
# Blocks that no model sees, beyond the largest number of blocks of a study.
FIRST_FRESH = 10_000
FRESH = range(FIRST_FRESH, FIRST_FRESH + CONFIG.learning.fresh_blocks)


def verbatim(value):
    """A parameter with text from outside, in which braces are no wildcards of Snakemake."""
    return lambda wildcards: value


def batch_paths(pattern, blocks=BLOCKS):
    """Paths of the tables of all batches of some blocks, by default those of the study."""
    return [
        pattern.format(block=f"{block:03d}", batch=f"{batch:03d}")
        for block in blocks
        for batch in range(len(BATCHES))
    ]


@cache
def seconds_of_batches(block):
    """Estimated computing times (s) of the cases of each batch of a block.

    They only set priorities and tell the time that a run will take.
    """
    # Imported here, as pandas and SciPy load slowly and only runs with simulations need them.
    from abradem.sampling.cost import batch_seconds
    from abradem.sampling.draw import block_cases

    drawn = block_cases(
        CONFIG.seed,
        block,
        CONFIG.sampling.cases_per_block,
        CONFIG.sampling.method,
        sampled_ranges(CONFIG),
        geometry=geometry_ranges(CONFIG),
    )
    return batch_seconds(drawn, SETUP, BATCHES)


def seconds_of_cases(wildcards):
    """Estimated computing times of the cases of a batch, s."""
    return seconds_of_batches(int(wildcards.block))[int(wildcards.batch)]


def seconds_of_batch(wildcards):
    """Estimated computing time of a batch, s."""
    return sum(seconds_of_cases(wildcards))


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


# The page of a table in the report, without the table.
TABLE_PAGE = file_of_workflow("workflow/report/table.html")

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


# Figures of the models of a geometry; those of single models of the paper are made on demand.
MODEL_GROUPS = (PHYSICAL_FIGURES, ALL_MODELS)


def is_made(name):
    """Whether a figure is made: some need simulations or results of other studies."""
    needs = {"verification": VERIFICATION_MADE, "speed": SPEED_MADE}
    if FIGURES[name].group in (CALIBRATION, SURFACE):
        # Other kinds of studies make these, see calibration.smk and geometry.smk.
        return False
    if WEARS_SURFACE:
        return FIGURES[name].group in MODEL_GROUPS
    return needs.get(name, SIMULATED or FIGURES[name].group != SIMULATIONS) and (
        SIMULATED or name != "setup"
    )


# Names of the formats in the report, which shows the first one by the alphabet.
REPORT_FORMATS = {"png": "image", "pdf": "print (PDF)"}


def figure_file(name, suffix):
    """The file of a figure in one format, with its entry in the report."""
    entry = FIGURES[name]
    return report(
        f"{RESULTS}/figures/{name}.{suffix}",
        caption="../report/caption.rst",
        category="Figures",
        subcategory=entry.group,
        labels={"figure": name, "format": REPORT_FORMATS.get(suffix, suffix)},
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
        labels={"file": f"{name}.tex"},
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


def unwritable(jobs):
    """One line for each folder in which the jobs of a run have to write and cannot."""
    files = [RESULTS + "/"]
    for job in jobs:
        files += [*job.output, *job.log, *([job.benchmark] if job.benchmark else [])]
    folders = dict.fromkeys(os.path.dirname(file) for file in files)
    return list(dict.fromkeys(filter(None, map(why_not_written, folders))))


def not_ready(jobs):
    """One line for each reason for which a run would fail at its end."""
    # Imported here, as a job of a run need not load what the readiness is found with.
    from abradem.report.movie import why_no_film
    from abradem.report.typeset import why_not_typeset
    from abradem.running.readiness import no_graphics_card, problems_at_start

    rules = {job.rule.name for job in jobs}
    stages = {Path(str(job.rule.snakefile)).stem for job in jobs}
    problems = []
    if SIMULATED and not CALIBRATES:
        cases = [
            int(job.wildcards.case) for job in jobs if hasattr(job.wildcards, "case")
        ]
        learns = not stages.isdisjoint({"baselines", "physical"})
        problems += problems_at_start(CONFIG, rules, learns, cases)
    if "ga_ann" in rules and workflow.local_exec:
        problems += no_graphics_card(CONFIG)
    for name, why_not in (("film", why_no_film), ("paper_pdf", why_not_typeset)):
        if name in rules and (reason := why_not()):
            problems.append(f"{name}: {reason}")
    return problems


def cases_to_simulate(job):
    """Number of cases that a job simulates."""
    if job.rule.name != "simulate":
        return 0
    return len(range(*BATCHES[int(job.wildcards.batch)]))


def batch_of(job):
    """The batch of cases of a job, for the progress monitor."""
    return BatchOfCases(
        runs=Path(job.output.runs),
        finished=Path(job.params.finished),
        seconds=seconds_of_cases(job.wildcards),
    )


def announce(dag, cores):
    """Say what a run simulates, and start the line of progress.

    Only the cases that the targets of the run need are counted: its graph has no others.
    """
    needed = sum(map(cases_to_simulate, dag.jobs))
    pending = {
        job.output.runs: batch_of(job)
        for job in dag.needrun_jobs()
        if cases_to_simulate(job)
    }
    count = sum(batch.cases for batch in pending.values())
    if not SIMULATED or count == CONFIG.cases:
        print(abradem.running.effort.estimate(CONFIG, cores), file=sys.stderr)
    elif count:
        every = CONFIG.cases + len(FRESH) * CONFIG.sampling.cases_per_block
        print(
            f"{CONFIG.study}: {count} of {every} cases are to be simulated",
            file=sys.stderr,
        )
    MONITOR.start(pending, needed)


def read_if_sound(path):
    """The content of a result that the report shows; {} if it is missing or damaged.

    A damaged one must not keep the run from starting that makes it again.
    """
    if not path.is_file():
        return {}
    try:
        if line := damage(path):
            raise TableError(line)
        found = read_json(path)
    except TableError as error:
        # Jobs, which read the rules again, repeat no warning.
        if workflow.is_main_process:
            print(f"warning: {error}", file=sys.stderr)
        return {}
    return found if isinstance(found, dict) else {}


def lift_rate_limit(scheduler):
    """Remove the default rate limit of job starts, unless the user has set one.

    To limit the rate to 100 jobs per second, Snakemake 9 checks all waiting jobs once a second,
    and once more each second for every finished job. This costs minutes per hour on two cores.
    """
    limiter = getattr(scheduler, "job_rate_limiter", None)
    if limiter is not None and (limiter.max_jobs, limiter.timespan) == (100, 1):
        scheduler.job_rate_limiter = None


# Replaces the locks of Snakemake, which a killed run leaves behind.
RUN_LOCK = lock_of_study(CONFIG.study)

# Processes ended for want of memory before this run.
KILLED_BEFORE = memory_kills()

MONITOR = Monitor(Path(RESULTS, ".finished"))

# Content of the overview of the report, available once the results exist. Its texts are escaped, as
# templates put them into reStructuredText.
OVERVIEW = Path(RESULTS, "overview.html")
SUMMARY = Path(RESULTS, "summary.json")
VERSIONS = Path(RESULTS, "versions.json")
config["caption_of"] = caption_in_rst
config["overview"] = str(OVERVIEW) if OVERVIEW.is_file() else ""
config["summary"] = data_for_rst(read_if_sound(SUMMARY))
config["recorded"] = data_for_rst(read_if_sound(VERSIONS))
config["run_times"] = data_for_rst(run_times(Path(RESULTS, "benchmarks")))
config["surface"] = WORN_SURFACE
config["resolved"] = data_for_rst(CONFIG.model_dump(mode="json"))


wildcard_constraints:
    block=r"\d+",
    batch=r"\d+",
    case=r"\d+",

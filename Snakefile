"""From the ranges in config.yaml to a wear data set, models, figures and a report.

snakemake                                               run the study of config.yaml
snakemake --configfile config.yaml studies/smoke.yaml   run another study (override file)
snakemake dataset                                       run up to one stage
snakemake verification                                  verify the engine
snakemake calibration                                   find the set-up that explains a table
snakemake movie | vtk | paper                           make a film, files for ParaView, a PDF
snakemake publish                                       make a folder ready for an archive
snakemake --list                                        list all targets and rules
"""

import sys
from pathlib import Path

try:
    from abradem.store.errors import memory_problem, too_small_limit

    if line := too_small_limit("the workflow", 1000):
        sys.exit(line)

    import abradem.config
    import abradem.running.effort
    import abradem.running.environment
except ModuleNotFoundError as error:
    sys.exit(
        f"{error.name} is not installed in {sys.executable}: "
        f"run `make setup`, or `pip install -e .` in {workflow.current_basedir}"
    )
except (ImportError, MemoryError, OSError) as error:
    sys.exit(memory_problem(error) or str(error))

abradem.running.environment.force_environment()

if not workflow.current_basedir.is_local:
    sys.exit(
        "abradem needs the files next to its Snakefile: import it from a clone, not from "
        f"{workflow.current_basedir.get_path_or_uri(secret_free=True)}"
    )

# The folder of this file; another workflow may import it as a module, with a configuration.
HOME = Path(workflow.current_basedir)
if problems := abradem.running.environment.environment_problems(HOME):
    sys.exit("\n".join(problems))
IN_MODULE = Path(workflow.main_snakefile).resolve() != Path(HOME, "Snakefile").resolve()

try:
    if not IN_MODULE:
        # Snakemake would execute templates (yte) in the configuration; refuse them here.
        abradem.config.refuse_all_but_data("config.yaml")
except abradem.config.ConfigError as error:
    sys.exit(str(error))


configfile: "config.yaml"


include: "workflow/rules/common.smk"


if CALIBRATES:

    include: "workflow/rules/calibration.smk"

    WHOLE_STUDY = rules.calibration.input

elif SIMULATED:

    include: "workflow/rules/sampling.smk"
    include: "workflow/rules/simulation.smk"
    include: "workflow/rules/scenes.smk"
    include: "workflow/rules/wear.smk"
    include: "workflow/rules/dataset.smk"

    STAGES_OF_SIMULATION = [
        rules.sampling.input,
        rules.simulation.input,
        rules.failures.output,
        rules.snapshots.input,
    ]

else:

    include: "workflow/rules/external.smk"

    STAGES_OF_SIMULATION = []


if WEARS_SURFACE and not CALIBRATES:

    include: "workflow/rules/running.smk"
    include: "workflow/rules/geometry.smk"

    WHOLE_STUDY = [
        STAGES_OF_SIMULATION,
        rules.dataset.output,
        rules.surface.input,
    ]
    if LEARNS_SURFACE:

        include: "workflow/rules/baselines.smk"
        include: "workflow/rules/physical.smk"
        include: "workflow/rules/learning.smk"
        include: "workflow/rules/figures.smk"
        include: "workflow/rules/report.smk"

        WHOLE_STUDY += [
            rules.learning.input,
            rules.figures.input,
            rules.documents.input,
        ]

elif not CALIBRATES:

    include: "workflow/rules/baselines.smk"
    include: "workflow/rules/physical.smk"
    include: "workflow/rules/learning.smk"
    include: "workflow/rules/running.smk"
    include: "workflow/rules/figures.smk"
    include: "workflow/rules/report.smk"

    if SIMULATED:

        # External tables are not published.
        include: "workflow/rules/publish.smk"

    WHOLE_STUDY = [
        STAGES_OF_SIMULATION,
        rules.dataset.output,
        rules.learning.input,
        rules.figures.input,
        rules.documents.input,
    ]


include: "workflow/rules/verification.smk"


localrules:
    all,
    verification,


# All stages; `snakemake --list` shows the other targets.
rule all:
    """The whole study: data set, models, figures, tables. The default target."""
    default_target: True
    input:
        WHOLE_STUDY,


onstart:
    to_run = list(workflow.dag.needrun_jobs())
    if problems := [*not_ready(to_run), *unwritable(to_run)]:
        sys.exit("\n".join(problems))
    if NOTHING_VARIES and any(job.rule.name in LEARNERS for job in to_run):
        sys.exit(NOTHING_VARIES)
    if not RUN_LOCK.take():
        sys.exit(
            f"{RESULTS}: {RUN_LOCK.holder()} is at work here; wait for its end"
        )
    lift_rate_limit(workflow.scheduler)
    announce(workflow.dag, workflow.cores)


onsuccess:
    MONITOR.stop()
    RUN_LOCK.release()


onerror:
    MONITOR.stop()
    if line := killed_for_memory(KILLED_BEFORE):
        print(line, file=sys.stderr)
    RUN_LOCK.release()

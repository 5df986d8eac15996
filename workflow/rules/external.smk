# An external table replaces sampling, simulation and data set.
from abradem.store.files import TableError
from abradem.dataset.external import read_external
from abradem.running.readiness import problems_of_table

EXTERNAL = CONFIG.dataset.external

try:
    if not Path(EXTERNAL).is_file():
        sys.exit(f"dataset.external: {EXTERNAL}: there is no such file")
    # Checked before anything is written; the rule reads the table again.
    problems = problems_of_table(
        CONFIG, read_external(EXTERNAL, CONFIG.dataset.columns)
    )
except OSError as error:
    sys.exit(f"dataset.external: {EXTERNAL}: cannot be read: {error.strerror}")
except TableError as error:
    sys.exit(str(error))
if problems:
    sys.exit("\n".join(problems))


rule dataset:
    """The data set from an external table."""
    output:
        report(
            f"{RESULTS}/dataset.parquet",
            caption="../report/external.rst",
            category="Data",
            labels={"table": "data set"},
        ),
    log:
        f"{LOGS}/dataset.log",
    conda:
        "../envs/abradem.yaml"
    params:
        # No input: Snakemake would take {words} in braces in its path for wildcards, and there is
        # no way to escape them. The content decides whether the data set is made again.
        table=verbatim(EXTERNAL),
        content=files_hash(EXTERNAL),
        columns=CONFIG.dataset.columns,
        damping_coefficient=CONFIG.features.damping_coefficient,
        code=code_of("dataset/external"),
    script:
        "../scripts/dataset/external.py"

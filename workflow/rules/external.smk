# An external table replaces sampling, simulation and data set.
from abradem.store.files import TableError
from abradem.running.given_tables import external_input

try:
    # Checked before anything is written; the rule reads the table again.
    EXTERNAL, REPEATED_ROWS, NOTHING_VARIES = external_input(CONFIG)
except TableError as error:
    sys.exit(str(error))


rule dataset:
    """The data set from an external table."""
    output:
        report(
            f"{RESULTS}/dataset.parquet",
            caption="../report/external.rst",
            category="Data",
            labels={"file": "dataset.parquet"},
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
        repeated=REPEATED_ROWS,
        code=code_of("dataset/external"),
    script:
        "../scripts/dataset/external.py"

# An external table replaces sampling, simulation and data set.
from abradem.store.files import TableError
from abradem.dataset.external import read_external

EXTERNAL = CONFIG.dataset.external

if not Path(EXTERNAL).is_file():
    sys.exit(f"dataset.external: {EXTERNAL}: there is no such file")
try:
    # Checked before anything is written; the rule reads the table again.
    read_external(EXTERNAL, CONFIG.dataset.columns)
except TableError as error:
    sys.exit(str(error))


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

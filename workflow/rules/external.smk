# In the place of sampling, simulation and dataset: a table from elsewhere.
from abradem.store.files import TableError
from abradem.dataset.external import read_external

EXTERNAL = CONFIG.dataset.external

if not Path(EXTERNAL).is_file():
    sys.exit(f"dataset.external: {EXTERNAL}: there is no such file")
try:
    # Before anything is written; the rule reads it again.
    read_external(EXTERNAL, CONFIG.dataset.columns)
except TableError as error:
    sys.exit(str(error))


rule dataset:
    """A table from elsewhere as the data set."""
    input:
        # Braces in a path are no wildcards.
        EXTERNAL.replace("{", "{{").replace("}", "}}"),
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
        columns=CONFIG.dataset.columns,
        damping_coefficient=CONFIG.features.damping_coefficient,
        code=code_of("dataset/external"),
    script:
        "../scripts/dataset/external.py"

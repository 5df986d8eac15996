# An external table replaces sampling, simulation and data set.
from abradem.store.files import TableError
from abradem.dataset.external import read_external, repeated
from abradem.dataset.user_table import local_file

try:
    EXTERNAL = str(local_file(CONFIG.dataset.external))
    # Checked before anything is written; the rule reads the table again.
    REPEATED_ROWS = repeated(read_external(EXTERNAL, CONFIG.dataset.columns))
except TableError as error:
    sys.exit(str(error))


rule dataset:
    """The data set from an external table."""
    input:
        # Braces in the path are not wildcards.
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
        repeated=REPEATED_ROWS,
        code=code_of("dataset/external"),
    script:
        "../scripts/dataset/external.py"

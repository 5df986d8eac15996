# An external table replaces sampling, simulation and data set.
from abradem.store.files import TableError
from abradem.dataset.external import read_external
from abradem.quantities import SAMPLED_NAMES

EXTERNAL = CONFIG.dataset.external

if not Path(EXTERNAL).is_file():
    sys.exit(f"dataset.external: {EXTERNAL}: there is no such file")
try:
    # Checked before anything is written; the rule reads the table again.
    if nothing_varies(
        read_external(EXTERNAL, CONFIG.dataset.columns)[list(SAMPLED_NAMES)].to_dict(
            "list"
        )
    ):
        NOTHING_VARIES = (
            f"dataset.external: {EXTERNAL}: every quantity has the same value in all rows, so "
            "nothing can be learned (allowed: at least one that varies)"
        )
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
        code=code_of("dataset/external"),
    script:
        "../scripts/dataset/external.py"

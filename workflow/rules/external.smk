# An external table replaces sampling, simulation and data set.
from abradem.store.files import TableError
from abradem.dataset.external import read_external, repeated
from abradem.dataset.user_table import local_file
from abradem.quantities import SAMPLED_NAMES
from abradem.running.readiness import problems_of_table

try:
    EXTERNAL = str(local_file(CONFIG.dataset.external))
except TableError as error:
    sys.exit(f"dataset.external: {error}")
try:
    # Checked before anything is written; the rule reads the table again.
    given_table = read_external(EXTERNAL, CONFIG.dataset.columns)
    REPEATED_ROWS = repeated(given_table)
    problems = problems_of_table(CONFIG, given_table)
    if nothing_varies(given_table[list(SAMPLED_NAMES)].to_dict("list")):
        NOTHING_VARIES = (
            f"dataset.external: {EXTERNAL}: every quantity has the same value in all rows, so "
            "nothing can be learned (allowed: at least one that varies)"
        )
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
        repeated=REPEATED_ROWS,
        code=code_of("dataset/external"),
    script:
        "../scripts/dataset/external.py"

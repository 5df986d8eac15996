"""The scores and predictions of all models, and their comparison."""

from abradem.running.job_log import start_job

start_job(snakemake)

from abradem.learning.comparison import (
    beside_paper,
    compare,
    join_tables,
    number_scores,
    with_scale,
)
from abradem.learning.model_files import write_stage
from abradem.learning.regions import error_by_region
from abradem.store.tables import read_table
from abradem.surrogate.groups import jet_of

dataset = read_table(snakemake.input.dataset)
predictions = with_scale(
    join_tables([read_table(path) for path in snakemake.input.predictions]),
    dataset,
    jet_of(snakemake.params.setup),
)
scores = join_tables(
    [
        *(read_table(path) for path in snakemake.input.scores),
        number_scores(predictions, snakemake.params.table),
    ]
)
comparison = compare(scores, predictions, **snakemake.params.options)
write_stage(
    snakemake.output.items(),
    scores=scores,
    predictions=predictions,
    comparison=comparison,
    beside_paper=beside_paper(comparison),
    by_region=error_by_region(predictions, dataset),
)

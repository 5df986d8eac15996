"""The scores and predictions of all models, and their comparison."""

from abradem.running.job_log import start_job

start_job(snakemake)

from abradem.learning.comparison import beside_paper, compare, join_tables
from abradem.learning.model_files import write_stage
from abradem.store.tables import read_table

scores = join_tables([read_table(path) for path in snakemake.input.scores])
predictions = join_tables([read_table(path) for path in snakemake.input.predictions])
comparison = compare(scores, predictions, **snakemake.params.options)
write_stage(
    snakemake.output.items(),
    scores=scores,
    predictions=predictions,
    comparison=comparison,
    beside_paper=beside_paper(comparison),
)

"""Power law, Gaussian process, boosting and ensemble of networks on dimensionless groups."""

from abradem.running.job_log import start_job

start_job(snakemake)

from abradem.learning.model_files import write_stage
from abradem.learning.physical.models import fit_physical, makers
from abradem.learning.physical.problem import problem
from abradem.learning.rows import FEWEST_ROWS
from abradem.store.tables import read_table
from abradem.surrogate.groups import group_names, jet_of

jet = jet_of(snakemake.params.setup)
given = problem(read_table(snakemake.input[0]), jet, **snakemake.params.table, fewest=FEWEST_ROWS)
models = makers(
    snakemake.params.options["seed"], **snakemake.params.models, groups=group_names(jet)
)
results, exponents, summary, process = fit_physical(given, models, **snakemake.params.options)
write_stage(
    snakemake.output.items(),
    scores=results.scores,
    predictions=results.predictions,
    exponents=exponents,
    summary=summary,
    process=process,
)

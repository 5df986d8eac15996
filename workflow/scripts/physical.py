"""Power law, Gaussian process, boosting and ensemble of networks on dimensionless groups."""

from abradem.dataset import read_table
from abradem.joblog import log_to
from abradem.learning.groups import jet_of
from abradem.learning.modelfile import write_stage
from abradem.learning.physical import fit_physical, makers, problem
from abradem.learning.table import FEWEST_ROWS

log_to(snakemake.log[0])

jet = jet_of(snakemake.params.setup)
given = problem(read_table(snakemake.input[0]), jet, **snakemake.params.table, fewest=FEWEST_ROWS)
models = makers(snakemake.params.options["seed"], **snakemake.params.models)
results, exponents, summary, process = fit_physical(given, models, **snakemake.params.options)
write_stage(
    snakemake.output.items(),
    scores=results.scores,
    predictions=results.predictions,
    exponents=exponents,
    summary=summary,
    process=process,
)

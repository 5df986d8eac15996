"""The surrogate behind `abradem predict`, and a score of its own."""

from abradem.dataset import read_json, read_table
from abradem.joblog import log_to
from abradem.learning.distil import Settings, evaluate_surrogate, surrogate_of
from abradem.learning.gaussian_process import GaussianProcess
from abradem.learning.groups import jet_of
from abradem.learning.modelfile import read_arrays, write_stage
from abradem.learning.physical import problem

log_to(snakemake.log[0])

jet = jet_of(snakemake.params.setup)
given = problem(read_table(snakemake.input.dataset), jet, **snakemake.params.table)
settings = Settings(**snakemake.params.settings)
results = evaluate_surrogate(given, settings, **snakemake.params.splits)
model = surrogate_of(
    given,
    GaussianProcess.of(read_arrays(snakemake.input.process)),
    read_json(snakemake.input.intervals)["scores"],
    settings,
    results,
    **snakemake.params.options,
)
write_stage(
    snakemake.output.items(),
    model=model,
    scores=results.scores,
    predictions=results.predictions,
)

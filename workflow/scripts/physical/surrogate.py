"""The surrogate for `abradem predict`, and its scores."""

from abradem.running.job_log import start_job

start_job(snakemake)

from abradem.learning.model_files import write_stage
from abradem.learning.physical.distil import Settings, evaluate_surrogate, surrogate_of
from abradem.learning.physical.gaussian_process import GaussianProcess
from abradem.learning.physical.intervals import Conformal
from abradem.learning.physical.noise_terms import terms
from abradem.learning.physical.problem import problem
from abradem.store.files import read_arrays, read_json
from abradem.store.tables import read_table
from abradem.surrogate.groups import jet_of

jet = jet_of(snakemake.params.setup)
given = problem(read_table(snakemake.input.dataset), jet, **snakemake.params.table)
settings = Settings(**snakemake.params.settings)
results = evaluate_surrogate(given, settings, **snakemake.params.splits)
model = surrogate_of(
    given,
    GaussianProcess.of(read_arrays(snakemake.input.process), terms),
    Conformal.of(read_json(snakemake.input.intervals), read_table(snakemake.input.errors)),
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

"""The surrogate for `abradem predict`, and its scores."""

from abradem.running.job_log import start_job

start_job(snakemake)

from abradem.learning.model_files import write_stage
from abradem.learning.physical.distil import Settings, evaluate_surrogate, surrogate_of
from abradem.learning.physical.gaussian_process import GaussianProcess
from abradem.learning.physical.intervals import Conformal
from abradem.learning.physical.local_wear import LocalWear, with_local_wear, with_meaning
from abradem.learning.physical.noise_terms import noise_terms
from abradem.learning.physical.problem import problem
from abradem.learning.physical.training_domain import with_domain
from abradem.store.files import read_arrays, read_json
from abradem.store.tables import read_table
from abradem.surrogate.groups import jet_of

jet = jet_of(snakemake.params.setup)
given = problem(read_table(snakemake.input.dataset), jet, **snakemake.params.table)
settings = Settings(**snakemake.params.settings)
results = evaluate_surrogate(given, settings, **snakemake.params.splits)
process = GaussianProcess.of(read_arrays(snakemake.input.process), noise_terms)
model = surrogate_of(
    given,
    process,
    Conformal.of(read_json(snakemake.input.intervals), read_table(snakemake.input.errors)),
    settings,
    results,
    **snakemake.params.options,
)
model = with_domain(model, process, given, snakemake.params.options["seed"])
local = LocalWear(
    read_json(snakemake.input.local)["local"], read_arrays(snakemake.input.local_arrays)
)
write_stage(
    snakemake.output.items(),
    model=with_meaning(with_local_wear(model, local), **snakemake.params.meaning),
    scores=results.scores,
    predictions=results.predictions,
)

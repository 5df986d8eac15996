"""Sensitivity of the wear to the sampled quantities."""

from abradem.running.job_log import start_job

start_job(snakemake)

from abradem.learning.model_files import write_stage
from abradem.learning.physical.gaussian_process import GaussianProcess
from abradem.learning.physical.noise_terms import noise_terms
from abradem.learning.physical.problem import problem
from abradem.learning.physical.sensitivity import partial_dependence, permutation, sobol, verdict
from abradem.store.files import read_arrays
from abradem.store.tables import read_table
from abradem.surrogate.groups import jet_of

jet = jet_of(snakemake.params.setup)
given = problem(read_table(snakemake.input.dataset), jet, **snakemake.params.table)
process = GaussianProcess.of(read_arrays(snakemake.input.process), noise_terms)
indices = sobol(process, given, **snakemake.params.sobol)
falls = permutation(given, **snakemake.params.splits)
write_stage(
    snakemake.output.items(),
    indices=indices,
    falls=falls,
    dependence=partial_dependence(process, given, snakemake.params.splits["seed"]),
    summary=verdict(indices),
)

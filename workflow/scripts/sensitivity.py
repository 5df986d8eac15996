"""Which quantities decide the wear."""

from abradem.dataset import read_table
from abradem.joblog import log_to
from abradem.learning.gaussian_process import GaussianProcess
from abradem.learning.groups import jet_of
from abradem.learning.modelfile import read_arrays, write_stage
from abradem.learning.physical import problem
from abradem.learning.sensitivity import partial_dependence, permutation, sobol, verdict

log_to(snakemake.log[0])

jet = jet_of(snakemake.params.setup)
given = problem(read_table(snakemake.input.dataset), jet, **snakemake.params.table)
process = GaussianProcess.of(read_arrays(snakemake.input.process))
indices = sobol(process, given, **snakemake.params.sobol)
falls = permutation(given, **snakemake.params.splits)
write_stage(
    snakemake.output.items(),
    indices=indices,
    falls=falls,
    dependence=partial_dependence(process, given, snakemake.params.splits["seed"]),
    summary=verdict(indices, falls),
)

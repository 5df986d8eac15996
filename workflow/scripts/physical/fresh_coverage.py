"""Coverage of the intervals of the surrogate on fresh cases."""

from abradem.running.job_log import start_job

start_job(snakemake)

from abradem.learning.model_files import write_stage
from abradem.learning.physical.fresh import coverage_of_fresh
from abradem.learning.physical.problem import problem
from abradem.store.tables import read_table
from abradem.surrogate.groups import jet_of
from abradem.surrogate.model import Surrogate

jet = jet_of(snakemake.params.setup)
given, fresh = (
    problem(read_table(path), jet, **snakemake.params.table)
    for path in (snakemake.input.dataset, snakemake.input.fresh)
)
coverage, summary = coverage_of_fresh(Surrogate.load(snakemake.input.surrogate), given, fresh)
write_stage(snakemake.output.items(), coverage=coverage, summary=summary)

"""Coverage of the intervals of the surrogate on fresh cases."""

from abradem.running.job_log import start_job

start_job(snakemake)

from abradem.learning.model_files import write_stage
from abradem.learning.physical.fresh import coverage_of_fresh
from abradem.learning.physical.problem import problem
from abradem.store.tables import read_table
from abradem.surrogate.groups import jet_of
from abradem.surrogate.model import Surrogate

jet, name = jet_of(snakemake.params.setup), snakemake.params.table["name"]
tables = [read_table(path) for path in (snakemake.input.dataset, snakemake.input.fresh)]
surrogate = Surrogate.load(snakemake.input.surrogate)
rates = [
    tuple(problem(table, jet, target, name) for table in tables) for target in surrogate.models
]
coverage, summary = coverage_of_fresh(surrogate, rates)
write_stage(snakemake.output.items(), coverage=coverage, summary=summary)

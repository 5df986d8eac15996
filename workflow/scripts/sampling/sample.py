"""One block of cases."""

from abradem.running.job_log import start_job

start_job(snakemake)

from abradem.dem.model import Setup
from abradem.sampling.draw import block_cases
from abradem.store.tables import write_table

cases = block_cases(
    block=int(snakemake.wildcards.block),
    setup=Setup.from_dict(snakemake.params.setup),
    **snakemake.params.options,
)
write_table(cases, snakemake.output[0])

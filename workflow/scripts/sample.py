"""One block of cases."""

from abradem.dataset import write_table
from abradem.joblog import log_to
from abradem.sampling import block_cases
from abradem.shards import setup_from_dict

log_to(snakemake.log[0])

cases = block_cases(
    block=int(snakemake.wildcards.block),
    setup=setup_from_dict(snakemake.params.setup),
    **snakemake.params.options,
)
write_table(cases, snakemake.output[0])

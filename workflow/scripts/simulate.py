"""The simulations of one shard."""

from abradem.dataset import read_table
from abradem.joblog import log_to
from abradem.shards import FILES, run_shard

log_to(snakemake.log[0])

start, stop = snakemake.params.rows
run_shard(
    read_table(snakemake.input.cases).iloc[start:stop],
    snakemake.params.setup,
    {name: snakemake.output[name] for name in FILES},
    finished=snakemake.params.finished,
    code=snakemake.params.code,
)

"""The simulations of one shard."""

from abradem.dataset import read_table
from abradem.joblog import log_to
from abradem.shards import run_shard

log_to(snakemake.log[0])

start, stop = snakemake.params.rows
run_shard(
    read_table(snakemake.input.cases).iloc[start:stop],
    snakemake.params.setup,
    {name: snakemake.output[name] for name in ("series", "maps", "runs")},
    finished=snakemake.params.finished,
    code=snakemake.params.code,
)

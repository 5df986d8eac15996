"""Snapshots of a case of the pictures."""

from pathlib import Path

from abradem.joblog import log_to
from abradem.scenes import write_scene
from abradem.shards import setup_from_dict

log_to(snakemake.log[0])

write_scene(
    snakemake.params.case,
    setup_from_dict(snakemake.params.setup),
    Path(snakemake.output.particles).parent,
    **snakemake.params.options,
)

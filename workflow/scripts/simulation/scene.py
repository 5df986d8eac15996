"""Snapshots of a short simulation for pictures."""

from pathlib import Path

from abradem.dem.model import Setup
from abradem.running.job_log import log_to
from abradem.simulation.snapshots import write_scene

log_to(snakemake.log[0])

write_scene(
    snakemake.params.case,
    Setup.from_dict(snakemake.params.setup),
    Path(snakemake.output.particles).parent,
    **snakemake.params.options,
)

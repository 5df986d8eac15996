"""Snapshots of a short simulation for pictures."""

from abradem.running.job_log import start_job

start_job(snakemake)

from pathlib import Path

from abradem.dem.model import Setup
from abradem.simulation.snapshots import write_scene

write_scene(
    snakemake.params.case,
    Setup.from_dict(snakemake.params.setup),
    Path(snakemake.output.particles).parent,
    **snakemake.params.options,
)

"""The simulation set-up: plate, factory and particles, and the wear."""

from pathlib import Path

from abradem.dataset import read_table
from abradem.figures import style
from abradem.figures.setup import setup_figure
from abradem.joblog import log_to
from abradem.scenes import depth_frames
from abradem.shards import setup_from_dict

log_to(snakemake.log[0])

case, setup = snakemake.params.case, setup_from_dict(snakemake.params.setup)
times, depth = depth_frames(read_table(snakemake.input.wear), case, setup)
particles = read_table(snakemake.input.particles)
last = particles[particles["time"] == times[-1]]
figure = setup_figure(last, depth[-1], times[-1], case, setup)
style.save(figure, Path(snakemake.output[0]).with_suffix(""), snakemake.params.formats)

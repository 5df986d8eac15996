"""The film of plates side by side, and its last frame."""

import matplotlib.image

from abradem.dem.model import Setup
from abradem.figures.film import Shot, frames
from abradem.report.movie import require_encoder, write_movie
from abradem.running.job_log import log_to
from abradem.store.files import replacing
from abradem.store.tables import read_table
from abradem.wear.depths import depth_frames

log_to(snakemake.log[0])

require_encoder()
setup = Setup.from_dict(snakemake.params.setup)
shots = [
    Shot(case, read_table(particles), *depth_frames(read_table(wear), case, setup))
    for case, particles, wear in zip(
        snakemake.params.cases, snakemake.input.particles, snakemake.input.wear, strict=True
    )
]
last = write_movie(
    frames(shots, setup, snakemake.params.width),
    snakemake.output.film,
    snakemake.params.per_second,
)
with replacing(snakemake.output.still) as sink:
    matplotlib.image.imsave(sink, last, format="png", metadata={"Software": None})

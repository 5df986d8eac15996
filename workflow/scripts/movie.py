"""The film of plates side by side, and its last picture."""

import matplotlib.image

from abradem.dataset import read_table, replacing
from abradem.figures.film import Shot, frames
from abradem.joblog import log_to
from abradem.movie import require_encoder, write_movie
from abradem.scenes import depth_frames
from abradem.shards import setup_from_dict

log_to(snakemake.log[0])

require_encoder()
setup = setup_from_dict(snakemake.params.setup)
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

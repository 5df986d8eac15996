"""The film of plates side by side, or of a geometry, and its last frame."""

from abradem.running.job_log import start_job

start_job(snakemake)

import matplotlib.image

from abradem.dem.model import Setup
from abradem.figures.film import frames, shot_of
from abradem.report.movie import require_encoder, write_movie
from abradem.store.files import replacing
from abradem.store.tables import read_table

require_encoder()
setup, measure = Setup.from_dict(snakemake.params.setup), snakemake.params.measure
shots = [
    shot_of(case, read_table(particles), read_table(wear), setup, measure)
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

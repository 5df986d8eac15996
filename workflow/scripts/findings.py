"""What the models say, in sentences."""

from abradem.dataset import read_json, read_table
from abradem.joblog import log_to
from abradem.learning.findings import findings, to_html
from abradem.provenance import write_text

log_to(snakemake.log[0])

given = snakemake.input
noise, speed = (read_json(given[name]) if given[name] else None for name in ("noise", "speed"))
paragraphs = findings(
    *(read_json(given[name]) for name in ("physical", "intervals", "surrogate", "sensitivity")),
    *(read_table(given[name]) for name in ("curve", "extrapolation")),
    noise,
    speed,
)
write_text(to_html(f"Models of study {snakemake.params.table}", paragraphs), snakemake.output[0])

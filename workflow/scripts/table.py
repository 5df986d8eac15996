"""A table as text, for reading."""

from abradem.dataset import read_table
from abradem.joblog import log_to
from abradem.provenance import write_text

log_to(snakemake.log[0])

write_text(read_table(snakemake.input[0]).to_csv(index=False), snakemake.output[0])

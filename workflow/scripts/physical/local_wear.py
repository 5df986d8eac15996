"""Models of the wear at other places of the plate than that of the target."""

from abradem.running.job_log import start_job

start_job(snakemake)

from abradem.learning.model_files import write_stage
from abradem.learning.physical.distil import Settings
from abradem.learning.physical.local_wear import local_wear
from abradem.store.tables import read_table
from abradem.surrogate.groups import jet_of

found = local_wear(
    read_table(snakemake.input[0]),
    jet_of(snakemake.params.setup),
    **snakemake.params.table,
    settings=Settings(**snakemake.params.settings),
    **snakemake.params.options,
)
write_stage(snakemake.output.items(), local=({"local": found.descriptions}, found.arrays))

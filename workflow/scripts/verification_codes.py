"""Independent codes under the same options."""

import pandas as pd
from abradem.joblog import log_to
from abradem.verification import codes
from abradem.verification.table import write

log_to(snakemake.log[0])

tables = codes.study(pd.read_csv(snakemake.input.impacts), pd.read_csv(snakemake.input.jets))
write(tables, {name: snakemake.output[name] for name in snakemake.params.tables})

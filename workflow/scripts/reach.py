"""The models with fewer cases, beyond their ranges, and on every target."""

from abradem.dataset import read_table
from abradem.joblog import log_to
from abradem.learning.groups import jet_of
from abradem.learning.modelfile import write_stage
from abradem.learning.physical import (
    BOOSTING,
    POWER_LAW,
    PROCESS,
    all_targets,
    makers,
    problem,
)
from abradem.learning.reach import extrapolate, learning_curve

log_to(snakemake.log[0])

dataset = read_table(snakemake.input[0])
jet = jet_of(snakemake.params.setup)
given = problem(dataset, jet, **snakemake.params.table)
every = makers(snakemake.params.curve["seed"], **snakemake.params.models)
models = {name: every[name] for name in (POWER_LAW, PROCESS, BOOSTING)}
two = {name: every[name] for name in (POWER_LAW, PROCESS)}
write_stage(
    snakemake.output.items(),
    curve=learning_curve(given, models, **snakemake.params.curve),
    extrapolation=extrapolate(given, models, snakemake.params.curve["seed"]),
    targets=all_targets(dataset, jet, two, **snakemake.params.targets),
)

"""Learning curves, extrapolation, and scores for all wear rates."""

from abradem.running.job_log import start_job

start_job(snakemake)

from abradem.learning.model_files import write_stage
from abradem.learning.physical.models import BOOSTING, POWER_LAW, PROCESS, all_targets, makers
from abradem.learning.physical.problem import problem
from abradem.learning.physical.reach import extrapolate, learning_curve
from abradem.store.tables import read_table
from abradem.surrogate.groups import group_names, jet_of

dataset = read_table(snakemake.input[0])
jet = jet_of(snakemake.params.setup)
given = problem(dataset, jet, **snakemake.params.table)
every = makers(snakemake.params.curve["seed"], **snakemake.params.models, groups=group_names(jet))
models = {name: every[name] for name in (POWER_LAW, PROCESS, BOOSTING)}
two = {name: every[name] for name in (POWER_LAW, PROCESS)}
write_stage(
    snakemake.output.items(),
    curve=learning_curve(given, models, **snakemake.params.curve),
    extrapolation=extrapolate(given, models, snakemake.params.curve["seed"]),
    targets=all_targets(dataset, jet, two, **snakemake.params.targets),
)

"""A figure, by the function of `abradem.figures` that the catalogue names."""

from abradem.running.job_log import start_job

start_job(snakemake)

from importlib import import_module
from pathlib import Path

from abradem.figures import style
from abradem.store.tables import read_results

module, function = snakemake.params.draw.split(":")
draw = getattr(import_module(f"abradem.figures.{module}"), function)
# Results that are not inputs of the rule are given by a parameter.
shown = {**dict(snakemake.input.items()), **snakemake.params.get("shown", {})}
figure = draw(**read_results(shown.items()), **snakemake.params.options)
style.save(
    figure,
    Path(snakemake.output[0]).with_suffix(""),
    [Path(path).suffix[1:] for path in snakemake.output],
)

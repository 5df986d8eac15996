"""Tables and numbers for a LaTeX text."""

from abradem.running.job_log import start_job

start_job(snakemake)

from abradem.report import latex
from abradem.store.files import write_text
from abradem.store.tables import read_result
from abradem.verification.results_page import PARTS
from abradem.words.labels import MODELS

study = snakemake.params.study
results = latex.CitedResults(
    {
        latex.CONFIG: snakemake.params.config,
        **{
            name: read_result(path)
            for name, path in zip(snakemake.params.names, snakemake.params.files, strict=True)
        },
    }
)
for name, text in {
    "numbers": latex.numbers_tex(latex.study_numbers(results), study),
    "quantities": latex.quantities_tex(results, study),
    "features": latex.features_tex(results, study),
    "exponents": latex.exponents_tex(results, study),
    "models": latex.models_tex(results, MODELS, study),
    "verification": latex.verification_tex(results, PARTS, study),
}.items():
    write_text(text, snakemake.output[name])

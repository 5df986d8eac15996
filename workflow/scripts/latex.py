"""Tables and numbers for a LaTeX text."""

from abradem import latex
from abradem.figures.words import MODELS
from abradem.joblog import log_to
from abradem.provenance import write_text
from abradem.verification.page import PARTS

log_to(snakemake.log[0])

study = snakemake.params.study
results = latex.Results(
    {
        latex.CONFIG: snakemake.params.config,
        **{
            name: latex.read_result(path)
            for name, path in zip(snakemake.params.names, snakemake.params.files, strict=True)
        },
    }
)
for name, text in {
    "numbers": latex.numbers_tex(latex.study_numbers(results), study),
    "quantities": latex.quantities_tex(results, study),
    "features": latex.features_tex(results, study),
    "models": latex.models_tex(results, MODELS, study),
    "verification": latex.verification_tex(results, PARTS, study),
}.items():
    write_text(text, snakemake.output[name])

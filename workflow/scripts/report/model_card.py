"""The model card of the surrogate."""

from abradem.running.job_log import start_job

start_job(snakemake)

from abradem.report.model_card import card_page, model_card
from abradem.store.files import write_json, write_text
from abradem.store.tables import read_results

card = model_card(**read_results(snakemake.input.items()), **snakemake.params.said)
write_json(card, snakemake.output.card)
write_text(card_page(card), snakemake.output.page)

# make run does everything: set-up, the study, its report. make help lists the rest.

PYTHON ?= python3
STUDY ?=
# Further options of snakemake, such as ARGS="--cores 1" or ARGS=--dry-run, or of make bench.
ARGS ?=

BIN := $(abspath .venv)/bin
# Scripts of the workflow that call `python` must find this one.
export PATH := $(BIN):$(PATH)

STAMP := .venv/.installed
FILES := config.yaml $(filter-out config.yaml,$(STUDY))

.DELETE_ON_ERROR:
.DEFAULT_GOAL := help
.PHONY: help setup run verify bench slurm-demo kills soak test lint clean

help: ## this list
	@grep -hE '^[a-z-]+:.*## ' $(MAKEFILE_LIST) | sed -E 's/:.*## /\t/' | expand -t 12

setup: $(STAMP) ## the environment .venv with everything in it

$(STAMP): pyproject.toml constraints.txt
	$(PYTHON) -m venv .venv
	$(BIN)/python -m pip install --quiet --disable-pip-version-check \
		--constraint constraints.txt --editable ".[test]"
	$(BIN)/python -m abradem.dem.warm
	@touch $@

run: $(STAMP) ## a study and its report: make run, make run STUDY=studies/smoke.yaml
	@folder=$$($(BIN)/abradem config --folder $(FILES)) && \
	$(BIN)/snakemake --configfile $(FILES) $(ARGS) && \
	$(BIN)/snakemake --configfile $(FILES) --report $$folder/.report.html --quiet && \
	mv -f $$folder/.report.html $$folder/report.html && \
	echo $$folder/report.html

verify: $(STAMP) ## the engine against what is known: results/verification/results.md
	@$(BIN)/snakemake verification $(ARGS) && echo results/verification/results.md

bench: $(STAMP) ## the engine timed against other codes: make bench ARGS="A B --clock cpu"
	$(BIN)/python benchmarks/speed.py --table results/benchmarks/speed.csv $(ARGS)
	$(if $(ARGS),,$(BIN)/python benchmarks/cost.py results/benchmarks)

slurm-demo: $(STAMP) ## the smoke study on a real Slurm of two nodes, where one is installed
	@$(BIN)/python profiles/slurm/demo.py $(ARGS)

kills: $(STAMP) ## a study killed and resumed, 50 times: make kills, make kills ARGS=10
	@$(BIN)/python tests/workflow/kills.py $(ARGS)

soak: $(STAMP) ## an hour of the engine on random cases: make soak, make soak ARGS="--minutes 5"
	@$(BIN)/python benchmarks/soak.py --table results/benchmarks/soak.csv $(ARGS)

test: $(STAMP) ## all tests
	$(BIN)/python -m pytest

lint: $(STAMP) ## style of the code and of the workflow
	$(BIN)/ruff check
	$(BIN)/ruff format --check
	$(BIN)/snakefmt --check Snakefile workflow
	$(BIN)/snakemake --lint

clean: ## remove all results and caches; the environment stays
	find results -mindepth 1 -maxdepth 1 ! -name README.md -exec rm -rf {} +
	rm -rf .snakemake .pytest_cache .ruff_cache .hypothesis build dist
	find src tests workflow -name __pycache__ -exec rm -rf {} +

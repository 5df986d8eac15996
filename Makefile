# `make run` sets up the environment, runs the study and writes its report. `make help` lists all
# targets.

ifneq ($(words $(CURDIR)),1)
$(error $(CURDIR): make and Snakemake cannot work in a folder with a blank in its path; move it)
endif

PYTHON ?= python3
STUDY ?=
# Further options for snakemake, such as ARGS="--cores 1" or ARGS=--dry-run, or for other targets.
ARGS ?=

BIN := $(abspath .venv)/bin
# Makes this Python the `python` of the workflow scripts.
export PATH := $(BIN):$(PATH)

# Test processes; each runs whole files, as tests of a file share what is expensive to make.
WORKERS ?= 2
PYTEST = $(BIN)/python -m pytest -n $(WORKERS) --dist loadfile

STAMP := .venv/.installed
DOCS_STAMP := .venv/.docs
FILES := config.yaml $(filter-out config.yaml,$(STUDY))

.DELETE_ON_ERROR:
.DEFAULT_GOAL := help
.PHONY: help setup run verify bench slurm-demo kills soak quick test lint docs clean

help: ## show this list
	@grep -hE '^[a-z-]+:.*## ' $(MAKEFILE_LIST) | sed -E 's/:.*## /\t/' | expand -t 12

setup: $(STAMP) ## create the environment .venv with all dependencies

$(STAMP): pyproject.toml constraints.txt
	$(PYTHON) -m venv .venv
	$(BIN)/python -m pip install --quiet --disable-pip-version-check \
		--constraint constraints.txt --editable ".[test]"
	$(BIN)/python -m abradem.dem.warm
	@touch $@

run: $(STAMP) ## run a study and write its report: make run, make run STUDY=studies/smoke.yaml
	@folder=$$($(BIN)/abradem config --folder $(FILES)) && \
	$(BIN)/snakemake --configfile $(FILES) $(ARGS) && \
	$(BIN)/snakemake --configfile $(FILES) --report $$folder/.report.html \
		--report-stylesheet workflow/report/report.css --quiet && \
	mv -f $$folder/.report.html $$folder/report.html && \
	echo $$folder/report.html

verify: $(STAMP) ## verify the engine: results/verification/results.md
	@$(BIN)/snakemake verification $(ARGS) && echo results/verification/results.md

bench: $(STAMP) ## compare the speed of the engine with other codes: make bench ARGS="A B --clock cpu"
	$(BIN)/python benchmarks/speed.py --table results/benchmarks/speed.csv $(ARGS)
	$(if $(ARGS),,$(BIN)/python benchmarks/cost.py results/benchmarks)

slurm-demo: $(STAMP) ## run the smoke study on a local Slurm cluster of two nodes, if Slurm is installed
	@$(BIN)/python profiles/slurm/demo.py $(ARGS)

kills: $(STAMP) ## kill and resume a study 50 times: make kills, make kills ARGS=10
	@$(BIN)/python tests/workflow/kills.py $(ARGS)

soak: $(STAMP) ## run the engine on random cases for an hour: make soak, make soak ARGS="--minutes 5"
	@$(BIN)/python benchmarks/soak.py --table results/benchmarks/soak.csv $(ARGS)

quick: $(STAMP) ## run the fast tests, in about a minute
	$(PYTEST) -m "not slow" $(ARGS)

test: $(STAMP) ## run all tests
	$(PYTEST) $(ARGS)

lint: $(STAMP) ## check the style of the code and of the workflow, and the types
	$(BIN)/ruff check
	$(BIN)/ruff format --check
	$(BIN)/snakefmt --check Snakefile workflow
	$(BIN)/snakemake --lint
	$(BIN)/mypy

docs: $(DOCS_STAMP) ## make the pages of the documentation: site/index.html
	NO_MKDOCS_2_WARNING=1 $(BIN)/mkdocs build --strict
	@echo site/index.html

# Apart from the environment of a study, which needs none of it.
$(DOCS_STAMP): $(STAMP)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check \
		--constraint constraints.txt --editable ".[docs]"
	@touch $@

clean: ## remove all results and caches, but keep the environment
	find results -mindepth 1 -maxdepth 1 ! -name README.md -exec rm -rf {} +
	rm -rf .snakemake .pytest_cache .ruff_cache .mypy_cache .hypothesis build dist site
	find src tests workflow -name __pycache__ -exec rm -rf {} +

# Targets for people; the work itself is in the Snakefile. `make help` lists them.
.DEFAULT_GOAL := help
.DELETE_ON_ERROR:
SHELL := /bin/sh

PYTHON ?= python3
CONFIG ?=
CORES ?=
PROFILE ?= workflow/profiles/default
VENV := .venv
BIN := $(VENV)/bin
STAMP := $(VENV)/jointclosure-is-set-up
SNAKEMAKE := $(BIN)/snakemake --workflow-profile $(PROFILE) $(if $(CORES),--cores $(CORES))

# one thread a job: the workflow runs one job on every core
export OMP_NUM_THREADS := 1
export OPENBLAS_NUM_THREADS := 1
export MKL_NUM_THREADS := 1
export NUMBA_NUM_THREADS := 1
export UV_SYSTEM_CERTS := 1
export UV_PYTHON_DOWNLOADS := never
export MPLBACKEND := Agg

.PHONY: help setup setup-slurm study smoke report hard-cases accuracy effects readings docs test test-all lint clean

help: ## List the targets
	@awk -F ':.*## ' '/^[a-z-]+:.*## /{printf "  make %-11s %s\n", $$1, $$2}' Makefile
	@echo "  CONFIG=config/mine.yaml runs another study, CORES=4 on so many cores, PYTHON=python3.12 chooses the Python,"
	@echo "  PROFILE=workflow/profiles/slurm runs it on a cluster (docs/clusters.md)."

setup: $(STAMP) ## Set up the locked environment in .venv (every other target does this too)

$(STAMP): requirements.lock requirements-uv.lock pyproject.toml
	@command -v $(PYTHON) >/dev/null 2>&1 || { echo "$(PYTHON) is not installed: apt-get install python3 python3-venv"; exit 1; }
	@$(PYTHON) -c 'import sys; v = sys.version_info[:2]; sys.exit(0 if (3, 11) <= v <= (3, 13) else "Python %d.%d is not supported: jointclosure needs Python 3.11, 3.12 or 3.13 (choose one by PYTHON=python3.12)" % v)'
	@$(PYTHON) -c 'import ensurepip, venv' 2>/dev/null || { echo "$(PYTHON) lacks venv: apt-get install python3-venv"; exit 1; }
	$(PYTHON) -m venv --clear $(VENV)
	@if $(BIN)/python -m pip install --quiet --disable-pip-version-check --require-hashes --requirement requirements-uv.lock; then \
	    $(BIN)/uv pip sync --quiet --require-hashes --compile-bytecode --python $(BIN)/python requirements.lock \
	    && $(BIN)/uv pip install --quiet --no-deps --no-build-isolation --python $(BIN)/python --editable . ; \
	else \
	    echo "uv is not to be had for this machine: pip does it, slower"; \
	    $(BIN)/python -m pip install --quiet --disable-pip-version-check --require-hashes --requirement requirements.lock \
	    && $(BIN)/python -m pip install --quiet --disable-pip-version-check --no-deps --no-build-isolation --editable . ; \
	fi
	@touch $@
	@echo "The environment is set up in $(VENV)."

setup-slurm: $(STAMP) ## Add what Slurm needs to it
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --no-deps --require-hashes --requirement requirements-slurm.lock

# a start after a kill: release the lock of a Snakemake that is no longer there
define unlock
	@if [ -n "$$(ls .snakemake/locks 2>/dev/null)" ]; then \
	    for pid in $$(pgrep -f "^[^ ]*python[^ ]* .*snakemake .*--workflow-profile"); do \
	        here=$$(readlink "/proc/$$pid/cwd" || pwd -P); \
	        [ "$$here" != "$$(pwd -P)" ] || { echo "another run is at work in this folder (process $$pid)"; exit 1; }; \
	    done; \
	    $(SNAKEMAKE) $(1) --unlock --quiet; fi
endef

define run
	@if [ -n "$(2)" ] && [ ! -f "$(2)" ]; then echo "CONFIG=$(2): there is no such file"; exit 1; fi
	@$(BIN)/python workflow/scripts/results_folder.py $(2) >/dev/null
	$(call unlock,$(1))
	$(if $(3),$(SNAKEMAKE) $(3) --configfile $(2))
	$(SNAKEMAKE) $(1)
	@echo "Results are in $$($(BIN)/python workflow/scripts/results_folder.py $(2))"
endef

study: $(STAMP) ## Run the paper's study, or that of CONFIG
	$(call run,$(if $(CONFIG),--configfile $(CONFIG)),$(CONFIG))

smoke: $(STAMP) ## Run the paper's study made small
	$(call run,--configfile config/smoke.yaml,config/smoke.yaml)

report: $(STAMP) ## Write the study, or that of CONFIG, as one page to read: results/<study>/report.html
	$(call run,report $(if $(CONFIG),--configfile $(CONFIG)),$(CONFIG))

hard-cases: $(STAMP) ## Close joints that are hard on a solver, and have an oracle judge them
	$(call unlock,)
	$(SNAKEMAKE) hard_cases
	@echo "Results are in results/hard_cases"
	@$(BIN)/python workflow/scripts/count_hard_cases.py results/hard_cases/tables/hard_cases.csv

accuracy: $(STAMP) ## Measure what accuracy costs in time (40 minutes on two cores)
	$(call run,accuracy --configfile $(or $(CONFIG),config/accuracy.yaml),$(or $(CONFIG),config/accuracy.yaml),estimate_accuracy)

effects: $(STAMP) ## Measure what each effect adds, and what it costs (up to an hour on two cores)
	$(call run,effects --configfile $(or $(CONFIG),config/effects.yaml),$(or $(CONFIG),config/effects.yaml),estimate_effects)

readings: $(STAMP) ## Ask which reading of the paper gives its Table 3 (ninety minutes on two cores)
	$(call run,readings --configfile $(or $(CONFIG),config/readings.yaml),$(or $(CONFIG),config/readings.yaml),estimate_readings)

docs: $(STAMP) ## Write reference pages from the docstrings and the schema to build/docs
	@$(BIN)/python workflow/scripts/reference_pages.py

test: $(STAMP) ## Pass the tests
	@echo "Compiling the kernels of all scenes (two minutes when they are new) ..."
	@$(BIN)/python -m jointclosure.warmup
	$(BIN)/python -m pytest -n auto -m "not slow"
	@echo "A study's own checks are in results/<study>/tables/checks.csv"

test-all: $(STAMP) ## Pass the tests, the slow ones too
	@$(BIN)/python -m jointclosure.warmup
	$(BIN)/python -m pytest -n auto

lint: $(STAMP) ## Check style, layers and workflow
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/snakefmt --check --compact-diff Snakefile workflow
	$(BIN)/lint-imports
	$(BIN)/snakemake --lint

clean: ## Remove the environment and all that was compiled, but no results
	rm -rf $(VENV) .pytest_cache .hypothesis .ruff_cache .import_linter_cache
	find src tests workflow -name __pycache__ -prune -exec rm -rf {} +

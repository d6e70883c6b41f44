# Targets for people; the work itself is in the Snakefile. `make help` lists them.
.DEFAULT_GOAL := help
.DELETE_ON_ERROR:
SHELL := /bin/sh

# What a user tells make is data. It is taken as it stands, so that make expands nothing in it, and goes
# through the environment to a Python that runs the target, so that no shell reads it. No recipe
# names $(CONFIG), $(CORES), $(PROFILE), $(PYTHON) or $(STUDY).
PYTHON ?= python3
CONFIG ?=
CORES ?=
PROFILE ?=
STUDY ?=
override PYTHON := $(value PYTHON)
override CONFIG := $(value CONFIG)
override CORES := $(value CORES)
override PROFILE := $(value PROFILE)
override STUDY := $(value STUDY)
export PYTHON CONFIG CORES PROFILE STUDY
UNKNOWN := $(strip $(foreach name,$(.VARIABLES),$(if $(findstring command,$(origin $(name))),$(name))))
ifneq ($(UNKNOWN),)
$(error $(UNKNOWN): not a variable of this Makefile, which has CONFIG, CORES, PROFILE, PYTHON and STUDY)
endif

VENV := .venv
BIN := $(VENV)/bin
STAMP := $(VENV)/jointclosure-is-set-up
DEVELOPMENT := $(VENV)/jointclosure-has-development-tools

# On Linux a recipe ends with make, whatever ends that, also by kill -9. `timeout` passes a signal on,
# and kills what has not ended 15 seconds later. What was started by a process that has ended before
# the kernel was asked to end both together goes no further: it compares the number of its parent.
UNTIL_KILLED := $(shell command -v setpriv >/dev/null && echo setpriv --pdeathsig KILL)
TIMEOUT := $(shell command -v timeout >/dev/null && echo timeout --foreground --kill-after=15 0)
MAKE_PID := $(shell echo $$PPID)
ifneq ($(UNTIL_KILLED),)
SHELL := $(shell command -v setpriv)
.SHELLFLAGS := --pdeathsig KILL /bin/sh -c
endif
WITH_MAKE := [ $$PPID = $(MAKE_PID) ] || exit 1; exec
ifneq ($(and $(TIMEOUT),$(UNTIL_KILLED)),)
WITH_MAKE += $(TIMEOUT) $(UNTIL_KILLED) /bin/sh -c '[ $$PPID = "$$0" ] && exec "$$@"' $$$$
else
WITH_MAKE += $(TIMEOUT)
endif
# What a user tells make about a study: a file of plain YAML, a folder, a number. A leading dash would
# be read as an option.
CHECK_GIVEN = case "$$CONFIG" in -*) CONFIG="./$$CONFIG";; esac; \
    [ -z "$$CONFIG" ] || $(BIN)/python -m studies.frame.yaml_files "$$CONFIG" || exit 2; \
    [ -z "$$PROFILE" ] || [ -f "$$PROFILE/config.yaml" ] \
    || { printf 'PROFILE=%s: there is no file config.yaml in it\n' "$$PROFILE" >&2; exit 2; }; \
    case "$$CORES" in all) ;; 0|*[!0-9]*) \
    printf 'CORES=%s: must be a number of cores, or all\n' "$$CORES" >&2; exit 2;; esac
SNAKEMAKE = $(CHECK_GIVEN); $(WITH_MAKE) $(BIN)/snakemake $${PROFILE:+--workflow-profile="$$PROFILE"} \
    $${CORES:+--cores="$$CORES"} --quiet host rules progress
GIVEN = $${CONFIG:+--configfile "$$CONFIG"}

# one thread a job: the workflow runs one job on every core
export OMP_NUM_THREADS := 1
export OPENBLAS_NUM_THREADS := 1
export MKL_NUM_THREADS := 1
export NUMBA_NUM_THREADS := 1
# each of a hundred processes would compile all modules again
export PYTHONDONTWRITEBYTECODE :=
export UV_SYSTEM_CERTS := 1
export UV_PYTHON_DOWNLOADS := never
export MPLBACKEND := Agg

WITHOUT_KERNELS := tests/statistics tests/storage tests/package studies/paper studies/frame/test_code_digests.py

.PHONY: help setup setup-slurm study smoke report hard-cases assess mismatch global-sensitivity estimate conclusions test test-all lint docs publish coverage mutants wheel lock clean size misalignment measured-joints

help: ## List the targets
	@awk -F ':.*## ' '/^[a-z-]+:.*## /{printf "  make %-11s %s\n", $$1, $$2}' Makefile
	@echo "  CONFIG=config/mine.yaml runs another study, CORES=4 on so many cores, PYTHON=python3.12 chooses the Python,"
	@echo "  PROFILE=profiles/slurm runs it on a cluster (docs/reference.md#run-on-a-cluster)."

setup: $(STAMP) ## Set up the locked environment in .venv (every other target does this too), and compile all kernels
	@echo "Loading the kernels (new ones are compiled, all of them in two minutes) ..."
	@$(WITH_MAKE) $(BIN)/python -m jointclosure.joint.warmup ship
	-@$(WITH_MAKE) $(BIN)/jointclosure doctor

$(STAMP): requirements.lock requirements-uv.lock pyproject.toml
	@command -v "$$PYTHON" >/dev/null 2>&1 || { printf '%s is not installed: apt-get install python3 python3-venv\n' "$$PYTHON"; exit 1; }
	@"$$PYTHON" -c 'import sys; v = sys.version_info[:2]; sys.exit(0 if (3, 11) <= v <= (3, 13) else "Python %d.%d is not supported: jointclosure needs Python 3.11, 3.12 or 3.13 (choose one by PYTHON=python3.12)" % v)'
	@"$$PYTHON" -c 'import ensurepip, venv' 2>/dev/null || { printf '%s lacks venv: apt-get install python3-venv\n' "$$PYTHON"; exit 1; }
	@"$$PYTHON" -c 'import os, sys; sys.exit("the name of this folder has a line break: no Python finds a package there" if "\n" in os.getcwd() else 0)'
	@if [ -L $(VENV) ]; then printf '$(VENV) is a link, and set-up would empty what it leads to: remove the link\n'; exit 1; fi
	@echo "Installing the packages of the environment in $(VENV) (two minutes) ..."
	@$(WITH_MAKE) "$$PYTHON" -m venv --clear $(VENV)
	@$(WITH_MAKE) /bin/sh -c 'if $(BIN)/python -m pip install --quiet --disable-pip-version-check --require-hashes --requirement requirements-uv.lock; then \
	    $(BIN)/uv pip sync --quiet --require-hashes --compile-bytecode --python $(BIN)/python requirements.lock \
	    && $(BIN)/uv pip install --quiet --no-deps --no-build-isolation --python $(BIN)/python --editable . ; \
	else \
	    echo "uv is not to be had for this machine: pip does it, slower"; \
	    $(BIN)/python -m pip install --quiet --disable-pip-version-check --require-hashes --requirement requirements.lock \
	    && $(BIN)/python -m pip install --quiet --disable-pip-version-check --no-deps --no-build-isolation --editable . ; \
	fi'
	@touch $@
	@echo "The environment is set up in $(VENV)."

$(DEVELOPMENT): $(STAMP) requirements-development.lock
	@$(WITH_MAKE) /bin/sh -c 'if [ -x $(BIN)/uv ]; \
	    then $(BIN)/uv pip install --quiet --require-hashes --compile-bytecode --python $(BIN)/python --requirement requirements-development.lock; \
	    else $(BIN)/python -m pip install --quiet --disable-pip-version-check --require-hashes --requirement requirements-development.lock; fi'
	@touch $@
	@echo "Tools for development are in $(VENV) too: linters, and what makes the documentation."

setup-slurm: $(STAMP) ## Add what Slurm needs to it
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --no-deps --require-hashes --requirement requirements-slurm.lock

study: $(STAMP) ## Run the paper's study, or that of CONFIG
	@$(SNAKEMAKE) $(GIVEN)

smoke: $(STAMP) ## Run a small version of the paper's study
	@$(SNAKEMAKE) --configfile config/smoke.yaml

report: $(STAMP) ## Write the study, or that of CONFIG, as one page to read: results/<study>/report.html
	@$(SNAKEMAKE) $(GIVEN) -- all report

conclusions: $(STAMP) ## Tabulate the evidence for each conclusion of the paper, from all studies that were run
	@$(SNAKEMAKE) $(GIVEN) -- all conclusions

hard-cases: $(STAMP) ## Simulate joints at the limits of the model, and check them by an independent implementation
	@$(SNAKEMAKE) -- hard_cases

assess: $(STAMP) ## Assess the paper's rocks or those of CONFIG: cost of accuracy, hardness, effects that are needed
	@$(SNAKEMAKE) --configfile studies/assessment/usual.yaml $${CONFIG:+"$$CONFIG"} -- assessment

mismatch: $(STAMP) ## Simulate mated, partly mated, independent and shifted walls (55 minutes of processor time)
	@$(SNAKEMAKE) --configfile "$${CONFIG:-studies/mismatch/mismatch.yaml}" -- mismatch

size: $(STAMP) ## Study the effects of patch length and grid spacing (95 minutes of processor time)
	@$(SNAKEMAKE) --configfile "$${CONFIG:-studies/size/size.yaml}" -- size

misalignment: $(STAMP) ## Simulate walls that are tilted, or rotated about the normal (34 minutes of processor time)
	@$(SNAKEMAKE) --configfile "$${CONFIG:-studies/misalignment/misalignment.yaml}" -- misalignment

measured-joints: $(STAMP) ## Compare three measured joints with simulated ones, for several choices of the model (60 minutes of processor time)
	@$(SNAKEMAKE) --configfile "$${CONFIG:-studies/measured_joints/measured_joints.yaml}" -- measured_joints

global-sensitivity: $(STAMP) ## Study properties and open choices that vary together (81 minutes of processor time)
	@$(SNAKEMAKE) --configfile "$${CONFIG:-studies/global_sensitivity/global_sensitivity.yaml}" -- global_sensitivity

estimate: $(STAMP) ## Estimate the time of the study, or of the experiments of CONFIG, from a few of their joints
	@$(SNAKEMAKE) $(GIVEN) -- estimate

test: $(STAMP) ## Run the tests
	@echo "Loading the kernels (new ones are compiled, all of them in two minutes), beside tests without kernels ..."
	@$(BIN)/python -m jointclosure.joint.warmup ship & \
	$(BIN)/python -m pytest -q -m "not slow" $(WITHOUT_KERNELS); passed=$$?; \
	wait $$! && exit $$passed
	$(BIN)/python -m pytest -n auto --dist loadfile -m "not slow" $(WITHOUT_KERNELS:%=--ignore=%)
	@echo "A study's own checks are in results/<study>/tables/checks.csv"

test-all: $(STAMP) ## Run all tests, including the slow ones
	@$(BIN)/python -m jointclosure.joint.warmup ship
	$(BIN)/python -m pytest -n auto --dist loadfile

lint: $(DEVELOPMENT) ## Check style, types, layers and workflow
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/snakefmt --check --compact-diff Snakefile workflow
	$(BIN)/mypy
	$(BIN)/lint-imports
	$(BIN)/snakemake --lint

docs: $(DEVELOPMENT) ## Write the pages made of templates, and build the site, without a network, to build/docs/index.html
	@$(BIN)/python docs/site/templates.py
	@$(BIN)/python docs/site/rulegraph.py
	@NO_MKDOCS_2_WARNING=1 $(BIN)/mkdocs build --strict

publish: $(STAMP) ## Store the results of STUDY=results/<run> that the documentation shows, in studies/<study>/published
	@$(BIN)/python docs/site/publish.py "$$STUDY"

mutants: $(STAMP) ## Test whether the fast tests detect wrong lines of the library (hours)
	@$(BIN)/python -m jointclosure.joint.warmup ship
	$(BIN)/python -m tests.mutants

coverage: $(DEVELOPMENT) ## Measure which lines the fast tests run (build/coverage/index.html; half an hour)
	$(BIN)/python -m pytest -m "not slow" --cov --cov-report=html:build/coverage --cov-report=term:skip-covered

wheel: $(STAMP) ## Build the package with its compiled kernels to build/wheel
	@$(BIN)/python -m jointclosure.joint.warmup ship
	$(BIN)/python -m hatchling build -t wheel -d build/wheel

LOCK := $(BIN)/uv pip compile --quiet --universal --fork-strategy fewest --generate-hashes --no-header --no-annotate

lock: $(DEVELOPMENT) ## Write requirements.lock and requirements-development.lock anew, keeping the versions that still fit (needs a network)
	$(LOCK) --extra workflow --extra walls --extra exchange --group test pyproject.toml --output-file requirements.lock
	$(LOCK) --extra workflow --extra walls --extra exchange --group dev pyproject.toml --constraint requirements.lock --output-file requirements-development.lock

clean: ## Remove the environment and all that was compiled, but no results
	rm -rf src/jointclosure/compiled $(VENV) .pytest_cache .hypothesis .ruff_cache .import_linter_cache .mypy_cache .coverage
	find src tests workflow -name __pycache__ -prune -exec rm -rf {} +

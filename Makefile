# Every verb sets the machine up first (scripts/setup.sh); when all is there that takes a tenth of a second.

.DEFAULT_GOAL := help
.DELETE_ON_ERROR:

BIN := $(or $(UV_PROJECT_ENVIRONMENT),.venv)/bin
DEMO := out/demo
DIR ?= $(DEMO)
WORKERS ?= $(shell nproc)
PYTEST_ARGS ?=

# One BLAS thread a process: the matrices are small, and there is a process a core already.
export OMP_NUM_THREADS ?= 1

.PHONY: help setup setup-dev setup-lint peers demo test test-slow check format bench report results clean

help: ## List the verbs
	@awk -F ':.*## ' '/^[a-z-]+:.*## / {printf "  make %-10s %s\n", $$1, $$2}' Makefile

setup: ## Install what is missing: OpenGL libraries, uv, the Python packages
	@scripts/setup.sh

setup-dev:
	@scripts/setup.sh --dev

setup-lint:
	@scripts/setup.sh --dev --no-render

# An environment of its own: OpenCV's two wheels own the same folder and must not meet.
peers: ## Install OpenCV's own trackers, to compare with, in .venv-peers
	@UV_PROJECT_ENVIRONMENT=.venv-peers scripts/setup.sh --dev --peers

demo: setup ## Grasp at three belt speeds; leaves a CSV, a table, a plot and a video in out/demo
	$(BIN)/beltgrasp sweep demo --out $(DEMO) --workers $(WORKERS)
	$(BIN)/beltgrasp report $(DEMO)
	$(BIN)/beltgrasp trial --tracker igpf --speed-mps 0.25 --seed 0 --video $(DEMO)/igpf_0.25mps.mp4
	@echo; echo "The demo left in $(DEMO):"
	@find $(DEMO) -type f ! -name '.*' | sort | sed 's/^/  /'

# LP_NUM_THREADS=0: software rendering starts no threads of its own; one core a process.
test: setup-dev ## Run the tests that together take minutes
	LP_NUM_THREADS=0 $(BIN)/pytest -n auto --maxprocesses 8 --dist worksteal -p no:benchmark $(PYTEST_ARGS)

test-slow: setup-dev ## Run only the tests marked slow
	$(BIN)/pytest -m slow $(PYTEST_ARGS)

check: setup-lint ## Check format, lint and types
	$(BIN)/ruff format --check
	$(BIN)/ruff check
	PYRIGHT_PYTHON_IGNORE_WARNINGS=1 $(BIN)/pyright

format: setup-lint ## Reformat the code and sort its imports
	$(BIN)/ruff check --fix --select I
	$(BIN)/ruff format

bench: setup-dev ## Measure a trial, a camera image, a tracker step and an IK solve
	LP_NUM_THREADS=0 $(BIN)/pytest benchmarks --benchmark-only -s $(PYTEST_ARGS)

report: setup ## Rebuild the tables and plots of a results folder: make report DIR=out/demo
	$(BIN)/beltgrasp report $(DIR)

results: setup ## Repeat the sweep of the README and put its table there
	$(BIN)/beltgrasp sweep loop --out results/loop --workers $(WORKERS)
	$(BIN)/beltgrasp report results/loop
	$(BIN)/python scripts/insert_tables.py

clean: ## Remove caches and generated results; keep the environment
	rm -rf out dist build .pytest_cache .ruff_cache .hypothesis .benchmarks
	find . -name __pycache__ -not -path './.venv*' -not -path './.uv/*' -prune -exec rm -rf {} +

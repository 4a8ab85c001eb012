# Everything a developer or CI needs, from nothing but Python 3.11 or later and make.
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
READY := $(VENV)/.ready
EXTRAS ?= dev
# Bytecode is made of what is imported, when it is: of all that is installed it takes as long as the rest of it.
PIP := --quiet --disable-pip-version-check --no-compile
# uv takes a fifth of the processor time of pip, which looks at every file of every package anew. Where it cannot be
# had, or does not find what pip's configuration finds, pip does it.
define install
	{ $(BIN)/python -m pip install $(PIP) uv --constraint constraints.txt \
	  && $(BIN)/uv pip install --quiet --python $(BIN)/python --editable '.[$(1)]' --constraint constraints.txt; } \
	|| $(BIN)/python -m pip install $(PIP) --editable '.[$(1)]' --constraint constraints.txt
endef

# The tests start many interpreters: without bytecode each takes about two seconds longer, compiling what it imports.
unexport PYTHONDONTWRITEBYTECODE

# The matrices of a fit are small: more threads only wait for one another.
export OPENBLAS_NUM_THREADS ?= 1
export OMP_NUM_THREADS ?= 1
# Arrays of a fit come and go: memory that is kept for the next ones is not asked for anew each time.
export MALLOC_MMAP_THRESHOLD_ ?= 33554432
export MALLOC_TRIM_THRESHOLD_ ?= 1073741824

.PHONY: help test lint demo bench soak lowest solvers pyodide site clean

help:  ## show this
	@grep -hE '^[a-z]+:.*## ' $(MAKEFILE_LIST) | sed -E 's/:.*## /\t/' | expand -t 8

# Rewriting the files for what an assertion would show takes 15 s where nothing is compiled yet: only what fails is run so.
test: lint  ## lint, types and the whole test suite
	$(BIN)/python -m pytest --assert=plain || { $(BIN)/python -m pytest --last-failed --last-failed-no-failures none; exit 1; }

lint: $(READY)  ## ruff and mypy
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy

demo: $(READY)  ## the whole story on embedded data; figures in results/demo/
	$(BIN)/springpot demo

bench: $(READY)  ## speed, side by side with the libraries
	$(BIN)/python -m pytest --benchmark-enable --benchmark-only -m "" tests/benchmarks

soak: $(READY)  ## all tests, also the long ones, with more examples, and all that can be broken; table in results/soak/
	$(BIN)/python -m pytest -m '' --hypothesis-profile=soak
	$(BIN)/python tests/reliability/soak.py

LOWEST := build/lowest
USED := figures,instruments,download,data,workbench
TESTERS := pytest pytest-benchmark hypothesis jsonschema xlwt
LOWEST_TESTS := rheology measurement identification structure report plugins cli test_api.py

lowest:  ## the lowest versions that pyproject.toml declares, in an environment of their own, and tests on them
	$(PYTHON) -m venv $(LOWEST)
	$(LOWEST)/bin/python -m pip install $(PIP) --editable '.[$(USED)]' $(TESTERS) --constraint constraints-lowest.txt
	$(LOWEST)/bin/python -m pytest $(addprefix tests/,$(LOWEST_TESTS))

solvers: $(READY)  ## the solvers that the tests hand models to; without them these tests are skipped
	$(call install,solvers)

pyodide: $(READY)  ## Python as it runs in a browser, for Node; without it the soak skips its test
	npm install --silent --no-fund --no-audit --prefix $(VENV)/node pyodide@314.0.7

site: $(READY)  ## the documentation as a site with its gallery, in build/site/
	$(BIN)/python docs/make_gallery.py
	NO_MKDOCS_2_WARNING=1 $(BIN)/mkdocs build --quiet --strict

clean:  ## remove the environment and whatever tools left behind
	rm -rf $(VENV) build dist .pytest_cache .mypy_cache .ruff_cache .hypothesis .benchmarks
	find . -name __pycache__ -type d -prune -exec rm -rf {} +
	find . -name '*.egg-info' -type d -prune -exec rm -rf {} +

# Made anew only when what it is made from has changed.
$(READY): pyproject.toml constraints.txt
	@test -x $(BIN)/python || $(PYTHON) -m venv $(VENV)
	$(call install,$(EXTRAS))
	@touch $@

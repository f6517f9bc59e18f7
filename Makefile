# make setup      install everything into .venv (the other targets do this first)
# make compare    run the comparison of the two backends
# make stability  run the catalogue of stiff and extreme scenes; ARGS=--quick for a part of it
# make test       quick tests on all cores; ARGS="-k patch" passes options on to pytest
# make test-slow  the tests that take minutes, one after the other
# make test-mpi   every test on several ranks
# make test-faults  every field of every scene broken: 75,000 bad inputs (5 min)
# make lint       ruff and mypy
# make docs       the documentation site, in build/site
# make dist       a wheel, in dist
# make clean      remove caches and build products; distclean removes .venv too
# PYTHON=/path/to/python3 is tried first when given.

PYTHON_IS_NEW_ENOUGH := import sys; sys.exit(sys.version_info < (3, 12))
# /usr/bin comes last: a version manager's python3 may hide it and still refuse to run here.
BASE_PYTHON := $(shell for python in $(PYTHON) python3 python3.14 python3.13 python3.12 \
	/usr/bin/python3; do $$python -c '$(PYTHON_IS_NEW_ENOUGH)' >/dev/null 2>&1 \
	&& { command -v $$python; break; }; done)
REQUIRE_PYTHON = @test -n "$(BASE_PYTHON)" || { echo >&2 "No Python 3.12 or newer found. \
	On Debian 13, Ubuntu 24.04 or later:  sudo apt-get install python3 python3-venv python3-dev"; \
	exit 1; }

BIN := .venv/bin
# The tests of a file, and at last all those on several ranks, keep to one worker: tests/conftest.py.
# A worker that dies ends the run: another in its place would wait for ranks that never come.
PARALLEL := --numprocesses auto --dist loadgroup --no-loadscope-reorder --max-worker-restart=0
INSTALLED := .venv/.installed

# Rank-parallel runs and parallel tests share the cores; threads on top only slow them down.
export OMP_NUM_THREADS ?= 1
export OPENBLAS_NUM_THREADS ?= 1
# Pictures are drawn off screen; without a display VTK would try X first, and complain.
export PYVISTA_OFF_SCREEN ?= true
ifndef DISPLAY
export VTK_DEFAULT_OPENGL_WINDOW ?= vtkEGLRenderWindow
endif

.PHONY: setup compare stability test test-slow test-mpi test-faults lint docs dist missing-packages clean \
	distclean

setup: $(INSTALLED)

# The stamp is written last, so an install that fails or is interrupted is taken up again.
$(INSTALLED): pyproject.toml constraints.txt
	$(REQUIRE_PYTHON)
	@$(BASE_PYTHON) setup/check_system.py
	$(BASE_PYTHON) -m venv .venv
	$(BIN)/python -m pip install --disable-pip-version-check -c constraints.txt -e '.[pictures,exact,maps,meshes,dev]'
	@touch $@

compare: $(INSTALLED)
	$(BIN)/cea study agreement $(ARGS)

stability: $(INSTALLED)
	$(BIN)/cea study stability $(ARGS)

test: $(INSTALLED)
	$(BIN)/pytest $(PARALLEL) $(ARGS)

test-slow: $(INSTALLED)
	$(BIN)/pytest -m slow $(ARGS)

test-mpi: $(INSTALLED)
	$(BIN)/pytest -m mpi $(ARGS)

test-faults: $(INSTALLED)
	$(BIN)/pytest -m 'slow or not slow' tests/scenes/test_bad_inputs.py $(ARGS)

lint: $(INSTALLED)
	$(BIN)/ruff check
	$(BIN)/ruff format --check
	$(BIN)/mypy
	$(BIN)/mypy setup

docs: $(INSTALLED)
	$(BIN)/python -m pip install --disable-pip-version-check -q -c constraints.txt -e '.[docs]'
	$(BIN)/python -m sphinx -W --keep-going -q -b html docs build/site
	@echo "The site to open: build/site/index.html"

# What an earlier build left would go into the wheel.
dist: $(INSTALLED)
	rm -rf build/lib build/bdist.* dist
	$(BIN)/python -m pip wheel --disable-pip-version-check -q --no-deps --wheel-dir dist .

missing-packages:
	$(REQUIRE_PYTHON)
	@$(BASE_PYTHON) setup/check_system.py --packages

clean:
	rm -rf build dist *.egg-info .pytest_cache .mypy_cache .ruff_cache
	find . -path ./.venv -prune -o -name __pycache__ -type d -exec rm -rf {} +

distclean: clean
	rm -rf .venv

# make run    the main job: a Pareto front for the built-in train on the built-in line, into out/
# make test   everything that CI checks
# make hooks  the checks that stand before the tests, before every commit
# make fuzz   slips of unit and mutated files, ten minutes of each; FUZZ="--seconds 3600 --processes 2" for more
# make fuzz-bounds  the same searches with every index of the kernels checked, five minutes of each
# make fuzz-readers  bytes that lead the readers into new branches, by atheris (Linux)
# make versions  the wheel in empty environments: each Python, lowest and newest dependencies
# make bench  all benchmarks, into results/benchmarks/; wants a quiet machine and about 15 minutes
# make proof  a survey of random trips on fresh seeds, into results/: SEEDS=1000 trips, none begun after MINUTES=15
# make windows  journeys with random windows on random lines against an explicit grid, into results/journeys/
# Both create .venv on first use. Another Python: make run PYTHON=python3.13
PYTHON ?= python3
SEEDS ?= 1000
MINUTES ?= 15
VENV := .venv
BIN := $(VENV)/bin
PIP_INSTALL := $(BIN)/python -m pip install --quiet --disable-pip-version-check

.PHONY: run test hooks fuzz fuzz-bounds fuzz-readers versions bench proof windows clean distclean

run: $(VENV)/.installed
	$(BIN)/python -m tgvdp search --out out

# The small kernel tests run first without the compiler, then with bounds checks; the whole suite comes last.
test: $(VENV)/.installed-dev
	$(BIN)/ruff check
	$(BIN)/ruff format --check
	$(BIN)/mypy
	NUMBA_DISABLE_JIT=1 $(BIN)/python -m pytest -m nojit
	NUMBA_BOUNDSCHECK=1 $(BIN)/python -m pytest -m nojit
	$(BIN)/python -m pytest

hooks: $(VENV)/.installed-dev
	$(BIN)/pre-commit install

fuzz: $(VENV)/.installed-dev
	$(BIN)/python -m fuzz --seed `date +%s` $(FUZZ)

fuzz-bounds: $(VENV)/.installed-dev
	NUMBA_BOUNDSCHECK=1 $(BIN)/python -m fuzz slips mutations --seconds 300 --seed `date +%s` $(FUZZ)

fuzz-readers: $(VENV)/.installed-dev
	$(PIP_INSTALL) -e ".[fuzz]"
	$(BIN)/python -m fuzz.coverage -max_total_time=600

versions: $(VENV)/.installed-dev
	$(BIN)/python -m tests.versions

bench: $(VENV)/.installed-peers
	$(BIN)/python -m benchmarks

proof: $(VENV)/.installed-dev
	$(BIN)/python -m benchmarks.proof --seeds $(SEEDS) --minutes $(MINUTES)

windows: $(VENV)/.installed-dev
	$(BIN)/python -m benchmarks.windows

$(BIN)/python:
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11) and f"tgvdp needs Python 3.11 or newer, $(PYTHON) is {sys.version.split()[0]}: try make PYTHON=python3.13")'
	$(PYTHON) -m venv $(VENV)

# The stamps are not older than pyproject.toml while the installed dependencies are those it lists.
$(VENV)/.installed: pyproject.toml | $(BIN)/python
	$(PIP_INSTALL) -e .
	@touch $@

$(VENV)/.installed-dev: pyproject.toml | $(BIN)/python
	$(PIP_INSTALL) -e ".[dev]"
	@touch $@ $(VENV)/.installed

$(VENV)/.installed-peers: pyproject.toml | $(BIN)/python
	$(PIP_INSTALL) -e ".[dev,peers]"
	@touch $@ $(VENV)/.installed $(VENV)/.installed-dev

clean:
	rm -rf out build dist .pytest_cache .mypy_cache .ruff_cache .hypothesis .coverage
	find src tests -name __pycache__ -type d -prune -exec rm -rf {} +

distclean: clean
	rm -rf $(VENV)

# Each target sets up .venv by itself.
PYTHON ?= python3
BIN := .venv/bin
SCENARIO ?= scenarios/dp_rov_tether.yaml

.PHONY: run test lint bench clean

run: .venv/installed
	$(BIN)/towline run $(SCENARIO)

# With bytecode kept: else each of the hundreds of processes that the tests start compiles the sources again.
test: export PYTHONDONTWRITEBYTECODE =
test: .venv/installed-dev
	$(BIN)/python tests/compile_all.py
	$(BIN)/pytest -n 2 --dist loadfile

lint: .venv/installed-dev
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/pyright
	$(BIN)/lint-imports

bench: .venv/installed-dev
	$(BIN)/towline bench all --page docs/benchmarks.md

clean:
	rm -rf .venv

.venv/bin/python:
	$(PYTHON) -m venv .venv

.venv/installed: pyproject.toml | .venv/bin/python
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --editable .
	touch $@

.venv/installed-dev: pyproject.toml | .venv/bin/python
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --editable '.[dev]'
	touch $@ .venv/installed

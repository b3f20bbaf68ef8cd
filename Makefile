# Everything from a bare clone, with python3 (3.11 or newer) and make alone: the first target that needs them makes
# .venv and installs what it needs there; nothing outside this folder is touched.
#
#   make demo    the whole way on a photograph of a brick wall; the report is demo/report.html
#   make test    the whole test suite
#   make lint    style, types and layers
#   make ci      what a change must pass: lint and test
#   make clean   remove .venv, caches and demo

PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
WORKERS ?= auto

# What a person's shell sets for other environments must not reach into this one.
unexport PYTHONPATH PYTHONHOME
export PIP_USER := 0
export PIP_DISABLE_PIP_VERSION_CHECK := 1

.PHONY: help demo test lint format ci clean
help:
	@sed -n 's/^#   //p' Makefile

demo: $(VENV)/installed-run
	$(BIN)/jaxtex demo -o demo
	@echo "Open the report: $(CURDIR)/demo/report.html"

test: $(VENV)/installed-test $(VENV)/installed-validator
	$(BIN)/python -m pytest -n $(WORKERS) --maxprocesses 8 --dist loadfile

lint: $(VENV)/installed-dev
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/lint-imports

format: $(VENV)/installed-dev
	$(BIN)/ruff check --fix .
	$(BIN)/ruff format .

ci: lint test

clean:
	rm -rf $(VENV) .cache .pytest_cache .mypy_cache .ruff_cache .import_linter_cache .hypothesis demo

$(VENV)/installed-run: EXTRAS :=
$(VENV)/installed-test: EXTRAS := [test]
$(VENV)/installed-dev: EXTRAS := [test,dev]

# Khronos' validator of glTF, where there is npm; where there is not, pytest says that its tests are skipped.
$(VENV)/installed-validator: | $(VENV)/made
	@if ! command -v npm >/dev/null; then echo "There is no npm: files are not put to Khronos' glTF validator"; \
	elif npm install --no-save --no-audit --no-fund --fetch-retries=0 --fetch-timeout=20000 --prefix $(VENV) \
		gltf-validator@2.0.0-dev.3.10 >/dev/null 2>&1; then touch $@; \
	else echo "npm did not get gltf-validator (no network?): files are not put to Khronos' glTF validator"; fi

$(VENV)/installed-%: pyproject.toml | $(VENV)/made
	@echo "Installing jaxtex and what it needs into $(VENV) (takes a minute or two, once)"
	@$(BIN)/python -m pip install --quiet --editable '.$(EXTRAS)'
	@touch $@

$(VENV)/made:
	@command -v $(PYTHON) >/dev/null || { echo "jaxtex needs Python 3.11 or newer, and there is no $(PYTHON);" \
		"name yours: make PYTHON=/path/to/python3 ..." >&2; exit 1; }
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || { echo "jaxtex needs Python 3.11 or newer, and" \
		"$(PYTHON) is $$($(PYTHON) -V 2>&1); name a newer one: make PYTHON=python3.12 ..." >&2; exit 1; }
	@$(PYTHON) -m venv $(VENV) || { echo "$(PYTHON) cannot make virtual environments; install its venv package" \
		"(Debian and Ubuntu: apt install python3-venv)" >&2; rm -rf $(VENV); exit 1; }
	@touch $@

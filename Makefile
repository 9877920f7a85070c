# Needs make and Python >= 3.11, nothing else: everything lives in .venv.
#   make convergence              the whole swinging-cube study -> reports/convergence/
#   make convergence ARGS=...     pass options on, e.g. ARGS="--resume --jobs 4"
#   make quick                    the same in its short form     -> out/convergence-quick/
#   make scenes                   the paper's other scenes and the stability study -> reports/
#   make reports-status           which reports are older than the code
#   make docs                     the site of docs/ -> docs/_build/html; warnings are errors
#   make pictures                 the pictures of the tutorial and the gallery, by running them
#   make test                     lint, types, tests: what CI runs
PYTHON ?= python3
VENV   := .venv
BIN    := $(VENV)/bin
ARGS   ?=
PIP    := $(BIN)/python -m pip install --quiet --disable-pip-version-check

.PHONY: help convergence quick scenes reports-status docs pictures test lint clean

help:
	@sed -n 's/^#  *\(make .*\)/\1/p' Makefile

convergence: $(VENV)/.installed-report
	$(BIN)/python -m studies.convergence $(ARGS)

quick: $(VENV)/.installed-report
	$(BIN)/python -m studies.convergence --quick $(ARGS)

scenes: $(VENV)/.installed-report
	for study in twisting_column conservation punch known_answers stability; do \
	  $(BIN)/python -m studies.$$study $(ARGS) || exit 1; done

reports-status: $(VENV)/.installed-report
	$(BIN)/python -m studies.engine.status

docs: $(VENV)/.installed-dev
	$(BIN)/python -m studies.readme_table
	$(BIN)/sphinx-build -W --keep-going -b html docs docs/_build/html $(ARGS)

pictures: $(VENV)/.installed-report
	$(BIN)/python -m studies.pages.code docs/tutorial.md
	$(BIN)/python -m studies.gallery $(ARGS)

test: lint
	$(BIN)/python -m pytest -m "not slow" --numprocesses auto --maxprocesses 4 --dist worksteal $(ARGS)

lint: $(VENV)/.installed-dev
	$(BIN)/ruff check .
	$(BIN)/mypy

clean:
	rm -rf $(VENV) build dist out docs/_build .pytest_cache .mypy_cache .ruff_cache
	find . -name __pycache__ -type d -prune -exec rm -rf {} +

# The stamps make an install happen again only when pyproject.toml changed.
$(VENV)/.installed-report: pyproject.toml | $(BIN)/python
	@echo "installing sphsolid and its report maker into $(VENV) ..."
	$(PIP) --editable ".[report]"
	@touch $@

$(VENV)/.installed-dev: pyproject.toml | $(BIN)/python
	@echo "installing sphsolid, its tests and its lint into $(VENV) ..."
	$(PIP) --editable ".[dev,report]"
	@touch $@ $(VENV)/.installed-report

$(BIN)/python:
	@$(PYTHON) -c 'import sys; sys.exit(0 if sys.version_info >= (3, 11) else "sphsolid needs Python >= 3.11 and $(PYTHON) is " + sys.version.split()[0] + "; name another one: make PYTHON=python3.12")'
	@$(PYTHON) -m venv $(VENV) || { rm -rf $(VENV); echo "cannot make $(VENV): on Debian and Ubuntu install python3-venv first"; exit 1; }

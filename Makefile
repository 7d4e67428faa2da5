# make demo     the main job, end to end         make test     all tests
# make derive N=20 [BOUNDARY=free] [INERTIA=uniform] [TERMS=all] [TARGET=numpy] [FORM=chain]
#             [EXPLICIT=1]                       make reference    regenerate the reference modules
# make figures    draw those of docs/derivation.md anew
# make thesis     rebuild the tables of the thesis into results/thesis/
# make lint, make types                          make bench, bench-rhs, bench-integrate, bench-analyse

PYTHON ?= python3
BIN := .venv/bin
LAYOUT := build/layout

N ?= 20
BOUNDARY ?= free
INERTIA ?= uniform
TERMS ?= all
TARGET ?= numpy
FORM ?= chain

.PHONY: demo derive test lint types bench bench-rhs bench-integrate bench-analyse reference figures thesis clean

demo: .venv/installed
	@$(BIN)/rodgen derive 20 --out generated
	@$(BIN)/rodgen run scenes/missile.toml

derive: .venv/installed
	@$(BIN)/rodgen derive "$(N)" --boundary "$(BOUNDARY)" --inertia "$(INERTIA)" \
		--terms "$(TERMS)" --target "$(TARGET)" --form "$(FORM)" $(if $(EXPLICIT),--explicit) --out generated

test: .venv/developing
	$(BIN)/python -m pytest -n auto

# The packages as they lie in a wheel: derive/ and templates/ inside rodgen/.
$(LAYOUT): .venv/developing
	@rm -rf $@ && mkdir -p $@
	@cp -R src/rodgen $@/rodgen && cp -R derive templates $@/rodgen/

lint: $(LAYOUT)
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	cd $(LAYOUT) && ../../$(BIN)/lint-imports --config ../../pyproject.toml --no-logo

types: $(LAYOUT)
	cd $(LAYOUT) && ../../$(BIN)/mypy --config-file ../../pyproject.toml -p rodgen

.PHONY: $(LAYOUT)

bench: .venv/installed
	@$(BIN)/python benchmarks/main_job.py

bench-rhs: .venv/installed
	@$(BIN)/python benchmarks/rhs.py

bench-integrate: .venv/installed
	@$(BIN)/python benchmarks/integrate.py

bench-analyse: .venv/installed
	@$(BIN)/python benchmarks/analyse.py

reference: .venv/developing
	$(BIN)/python -m pytest tests/generated/test_reference_modules.py --update

thesis: .venv/installed
	@$(BIN)/rodgen thesis

figures: .venv/installed
	@$(BIN)/python -m rodgen.view.model_figures docs/pictures

.venv/bin/python:
	@$(PYTHON) -c "import sys; sys.exit(None if sys.version_info >= (3, 11) else \
		'rodgen needs Python 3.11 or later: make PYTHON=python3.12 ...')"
	@echo "setting up .venv"
	@$(PYTHON) -m venv .venv

# What using rodgen needs; working on it needs more, and has this with it.
.venv/installed: pyproject.toml | .venv/bin/python
	@$(BIN)/python -m pip install --quiet --disable-pip-version-check --editable ".[c]"
	@touch $@

.venv/developing: pyproject.toml | .venv/bin/python
	@$(BIN)/python -m pip install --quiet --disable-pip-version-check --editable ".[dev]"
	@touch .venv/installed $@

clean:
	rm -rf build results .pytest_cache .mypy_cache .ruff_cache .import_linter_cache

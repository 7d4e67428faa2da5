# make demo     the main job, end to end         make test     all tests but the long
# make view [SCENE=scenes/missile.toml]          the live view, in a browser
# make derive N=20 [BOUNDARY=free] [INERTIA=uniform] [TERMS=all] [TARGET=numpy] [FORM=chain]
#             [EXPLICIT=1]                       make reference    regenerate the reference modules
# make figures    draw those of docs/derivation.md anew       make screenshot   the live view's picture
# make thesis     rebuild the tables of the thesis into results/thesis/
# make guide      take the numbers of README and docs/which-method.md from the last report
# make report [QUICK=1] [RESUME=1]    error against run time, stability, extremes, beside peers
# make test-all   the long tests as well         make lint, make types
# make bench, bench-rhs, bench-analyse, bench-live

PYTHON ?= python3
BIN := .venv/bin
LAYOUT := build/layout

N ?= 20
BOUNDARY ?= free
INERTIA ?= uniform
TERMS ?= all
TARGET ?= numpy
FORM ?= chain
SCENE ?= scenes/missile.toml

.PHONY: demo view derive test test-all lint types bench bench-rhs bench-analyse bench-live reference figures screenshot thesis \
	report guide clean

demo: .venv/installed
	@$(BIN)/rodgen derive 20 --out generated
	@$(BIN)/rodgen run scenes/missile.toml

view: .venv/viewing
	@$(BIN)/rodgen view "$(SCENE)"

derive: .venv/installed
	@$(BIN)/rodgen derive "$(N)" --boundary "$(BOUNDARY)" --inertia "$(INERTIA)" \
		--terms "$(TERMS)" --target "$(TARGET)" --form "$(FORM)" $(if $(EXPLICIT),--explicit) --out generated

test: .venv/developing
	$(BIN)/python -m pytest -n auto

test-all: test
	$(BIN)/python -m pytest -n auto -m long

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

bench-analyse: .venv/installed
	@$(BIN)/python benchmarks/analyse.py

bench-live: .venv/developing
	@$(BIN)/python benchmarks/live.py $(or $(SECONDS),20) $(LINKS)

reference: .venv/developing
	$(BIN)/python -m pytest tests/generated/test_reference_modules.py --update

thesis: .venv/installed
	@$(BIN)/rodgen thesis

# Peers that cannot be had here are named on the page.
report: .venv/benchmarking
	@$(BIN)/rodgen report $(if $(QUICK),--quick) $(if $(RESUME),--resume)

# What README and docs/which-method.md show, from the report that was made last.
guide: .venv/installed
	@mkdir -p docs/report && cp results/report/report.json docs/report/
	@$(BIN)/python -m rodgen.view.report_readme docs/report/report.json README.md
	@$(BIN)/python -m rodgen.view.report_guide docs/report/report.json docs/pictures

figures: .venv/installed
	@$(BIN)/python -m rodgen.view.model_figures docs/pictures

screenshot: .venv/developing
	$(BIN)/python -m pytest tests/live/test_screenshots.py --update

.venv/bin/python:
	@$(PYTHON) -c "import sys; sys.exit(None if sys.version_info >= (3, 11) else \
		'rodgen needs Python 3.11 or later: make PYTHON=python3.12 ...')"
	@echo "setting up .venv"
	@$(PYTHON) -m venv .venv
	@# Else a folder that is called rodgen and lies beside a script, such as a clone, hides the package.
	@echo "$(CURDIR)/src" > "$$($@ -c 'import sysconfig; print(sysconfig.get_path("purelib"))')/rodgen_source.pth"

# What using rodgen needs; working on it needs more, and has this with it.
.venv/installed: pyproject.toml | .venv/bin/python
	@$(BIN)/python -m pip install --quiet --disable-pip-version-check --editable ".[c]"
	@touch $@

.venv/viewing: pyproject.toml | .venv/installed
	@$(BIN)/python -m pip install --quiet --disable-pip-version-check --editable ".[view]"
	@touch $@

.venv/developing: pyproject.toml | .venv/bin/python
	@$(BIN)/python -m pip install --quiet --disable-pip-version-check --editable ".[dev]"
	@touch .venv/installed $@

.venv/benchmarking: pyproject.toml | .venv/installed
	@$(BIN)/python -m pip install --quiet --disable-pip-version-check --editable ".[bench]" \
		|| echo "not all peers can be installed here: the page names those that are missing"
	@touch $@

clean:
	rm -rf build results .pytest_cache .mypy_cache .ruff_cache .import_linter_cache

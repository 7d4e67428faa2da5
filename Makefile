# make demo     the main job, end to end         make test     all tests but the long
# make view [SCENE=scenes/missile.toml]          the live view, in a browser
# make derive N=20 [BOUNDARY=free] [INERTIA=uniform] [TERMS=all] [TARGET=numpy] [FORM=chain]
#             [PARTS=rhs,jac] [STEPS=1] [EXPLICIT=1]        make reference    regenerate the reference modules and the keys in docs/scenes.md
# make figures    draw those of docs/derivation.md anew       make screenshot   the live view's picture
# make thesis     rebuild the tables of the thesis into results/thesis/       make audit   its equations and listing
# make guide      take the numbers of docs/speed.md and docs/which-method.md from the last report
# make report [QUICK=1] [RESUME=1]    error against run time, stability, extremes, beside peers
# make test-all   the long tests as well         make lint, make types
# make bench, bench-rhs, bench-many, bench-heyoka, bench-study, bench-engine, bench-workers, bench-load, bench-kills
# make bench-analyse, bench-exponents, bench-cycles, bench-live

PYTHON ?= python3
BIN := .venv/bin
LAYOUT := build/layout
# Each worker begins with a stretch of neighbours, which share what is compiled for them.
SPREAD := -n auto --dist worksteal
# They start a hundred processes, which do not compile the sources anew each, whatever is set.
PYTEST := PYTHONDONTWRITEBYTECODE= $(BIN)/python -m pytest

# Rooms whose public functions have examples.
EXAMPLES := $(addprefix src/rodgen/,scene loading native integrate analyse studies)

N ?= 20
BOUNDARY ?= free
INERTIA ?= uniform
TERMS ?= all
TARGET ?= numpy
FORM ?= chain
PARTS ?= all
SCENE ?= scenes/missile.toml

.PHONY: demo view derive test test-all lint types bench bench-rhs bench-many bench-heyoka bench-study bench-engine bench-workers bench-load bench-kills bench-analyse bench-exponents bench-cycles bench-live docs reference figures screenshot thesis audit \
	report guide clean

demo: .venv/installed
	@$(BIN)/rodgen derive 20 --out generated
	@$(BIN)/rodgen run scenes/missile.toml

view: .venv/viewing
	@$(BIN)/rodgen view "$(SCENE)"

derive: .venv/installed
	@$(BIN)/rodgen derive "$(N)" --boundary "$(BOUNDARY)" --inertia "$(INERTIA)" \
		--terms "$(TERMS)" --target "$(TARGET)" --form "$(FORM)" --parts "$(PARTS)" \
		$(if $(STEPS),--with-steps) $(if $(EXPLICIT),--explicit) --out generated

test: .venv/developing
	$(PYTEST) $(SPREAD)

test-all: test .venv/evidence docs
	$(PYTEST) $(SPREAD) -m long
	$(PYTEST) $(SPREAD) -m "long or not long" evidence/tests
	@# The pieces of a page follow one another, in one worker.
	$(PYTEST) -n auto --dist loadfile -m "long or not long" docs
	$(PYTEST) $(SPREAD) -m "long or not long" --doctest-modules $(EXAMPLES)

# The packages as they lie in a wheel: derive/, templates/ and scenes/ inside rodgen/.
$(LAYOUT): .venv/developing .venv/evidence
	@rm -rf $@ && mkdir -p $@
	@cp -R src/rodgen $@/rodgen && cp -R derive templates scenes $@/rodgen/ && cp -R evidence/src/rodgen_evidence $@/

lint: $(LAYOUT)
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/codespell $$(git ls-files | grep -vE '\.(svg|png|gif|json|netcdf|js|css)$$')
	$(BIN)/proselint --config .proselintrc.json check $$(git ls-files '*.md' | grep -v docs/audit.md)
	cd $(LAYOUT) && ../../$(BIN)/lint-imports --config ../../pyproject.toml --no-logo

types: $(LAYOUT)
	cd $(LAYOUT) && ../../$(BIN)/mypy --config-file ../../pyproject.toml -p rodgen -p rodgen_evidence

.PHONY: $(LAYOUT)

bench: .venv/evidence
	@$(BIN)/python -m rodgen_evidence.benchmarks.main_job

bench-rhs: .venv/evidence
	@$(BIN)/python -m rodgen_evidence.benchmarks.rhs

bench-many: .venv/evidence
	@$(BIN)/python -m rodgen_evidence.benchmarks.many

bench-heyoka: .venv/evidence
	@$(BIN)/python -m rodgen_evidence.benchmarks.many_heyoka $(LINKS) $(if $(PLAIN),plain)

bench-study: .venv/evidence
	@$(BIN)/python -m rodgen_evidence.benchmarks.study

bench-exponents: .venv/evidence
	@$(BIN)/python -m rodgen_evidence.benchmarks.exponents

bench-cycles: .venv/evidence
	@$(BIN)/python -m rodgen_evidence.benchmarks.cycles

bench-analyse: .venv/evidence
	@$(BIN)/python -m rodgen_evidence.benchmarks.analyse

bench-engine: .venv/developing .venv/evidence
	@$(BIN)/python -m rodgen_evidence.benchmarks.study_engine $(RUNS) $(TASKS)

bench-workers: .venv/developing .venv/evidence
	@$(BIN)/python -m rodgen_evidence.benchmarks.study_workers $(BLOCKS) $(WORKERS)

bench-load: .venv/developing .venv/evidence
	@$(BIN)/python -m rodgen_evidence.benchmarks.study_load $(TASKS) $(WORKERS)

bench-kills: .venv/developing .venv/evidence
	@$(BIN)/python -m rodgen_evidence.benchmarks.study_kills $(STUDIES)

bench-live: .venv/developing .venv/evidence
	@$(BIN)/python -m rodgen_evidence.benchmarks.live $(or $(SECONDS),20) $(LINKS) $(if $(AGAINST),--against $(AGAINST))

reference: .venv/developing
	$(BIN)/python -m pytest tests/generated/test_reference_modules.py tests/scene/test_documentation.py tests/studies/test_documentation.py --update

thesis: .venv/evidence
	@$(BIN)/rodgen thesis

audit: .venv/evidence
	@$(BIN)/rodgen audit

# Peers that cannot be had here are named on the page.
report: .venv/peers
	@$(BIN)/rodgen report $(if $(QUICK),--quick) $(if $(RESUME),--resume)

# What docs/speed.md and docs/which-method.md show, from the report that was made last.
guide: .venv/evidence
	@mkdir -p docs/report && cp results/report/report.json docs/report/
	@$(BIN)/python -m rodgen_evidence.pages.report_guide docs/report/report.json docs/speed.md docs/which-method.md

# The site, in build/site: open index.html there.
docs: .venv/documenting
	@$(BIN)/python -m sphinx -W --keep-going -q -j auto docs build/site
	@echo "build/site/index.html"

figures: .venv/evidence
	@$(BIN)/python -m rodgen_evidence.figures.model_figures docs/pictures
	@$(BIN)/python -m rodgen_evidence.figures.rocket_figures scenes/sounding_rocket.toml docs/pictures
	@$(BIN)/python -m rodgen_evidence.figures.branch_figures scenes docs/pictures
	@$(BIN)/python -m rodgen_evidence.figures.cycle_figures scenes docs/pictures

screenshot: .venv/developing
	$(BIN)/python -m pytest -m long tests/live/test_appearance.py -k shows_a_rod --update

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

.venv/documenting: pyproject.toml | .venv/bin/python
	@$(BIN)/python -m pip install --quiet --disable-pip-version-check --editable ".[docs]"
	@touch .venv/installed $@

# What shows how far rodgen can be trusted: the commands report, thesis and audit.
.venv/evidence: evidence/pyproject.toml | .venv/installed
	@$(BIN)/python -m pip install --quiet --disable-pip-version-check --editable evidence
	@touch $@

.venv/peers: evidence/pyproject.toml | .venv/evidence
	@$(BIN)/python -m pip install --quiet --disable-pip-version-check --editable "evidence[peers]" \
		|| echo "not all peers can be installed here: the page names those that are missing"
	@touch $@

clean:
	rm -rf build results .pytest_cache .mypy_cache .ruff_cache .import_linter_cache

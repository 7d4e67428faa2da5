# make demo     the main job, end to end
# make test     the tests of every day              make test-times [COUNT=40]    processor time of each, of the last runs
# make check    lint, types, slower tests, the live view in a browser, the pages of docs/
# make check-clean      .ci/run (demo, test, check) in a clean clone of HEAD; if green, noted in build/checked
# make check-all        everything, and every seeded fault: make faults [FROM=1] [TO=20] [AGAIN=1]
# make check-newest     the same but the faults, with the newest dependencies, warnings are errors    make check-lowest   the oldest
# make check-package    what pip installs, alone    make check-joints   with JAX, diffrax, Numba     make lock   the versions of all dependencies
# make view [SCENE=scenes/missile.toml]          the live view, in a browser
# make derive N=20 [BOUNDARY=free] [INERTIA=uniform] [TERMS=all] [TARGET=numpy] [FORM=chain]
#             [PARTS=rhs,jac] [STEPS=1] [EXPLICIT=1]
# make reference [CHECK=1]    write the reference modules and the keys in docs/scenes.md anew, or compare them
# make figures    draw those of docs/derivation.md anew       make screenshot   the live view's picture
# make thesis     rebuild the tables of the thesis into results/thesis/       make audit   its equations and listing
# make guide      take the numbers of docs/speed.md and docs/which-method.md from the last report
# make report [QUICK=1] [RESUME=1]    error against run time, stability, extremes, beside peers
# make bench, bench-rhs, bench-many, bench-heyoka, bench-study, bench-engine, bench-workers, bench-load, bench-kills
# make bench-analyse, bench-exponents, bench-cycles, bench-tables, bench-live
# make verdicts [SCENES=200]    stability of random rods against 50 digits, their rests in a wind against plain continuation
# make tolerance [SCENES=300]   errors of runs over their tolerances, and what methods cost at equal error, on random rods

PYTHON ?= python3
VENV ?= .venv
BIN := $(VENV)/bin
# Versions of all that is installed here; without it (LOCK=), the newest.
LOCK ?= requirements.lock
INSTALL = $(BIN)/python -m pip install --quiet --disable-pip-version-check $(addprefix --constraint ,$(LOCK))
# $(call compile,OPTIONS,REQUIREMENTS,FILE): the versions of all that REQUIREMENTS need.
compile = $(INSTALL) uv && printf '%s\n' $(2) | $(BIN)/python -m uv pip compile - --quiet --no-annotate --custom-compile-command "make lock" \
	--no-emit-package rodgen --no-emit-package rodgen-evidence $(1) --output-file $(3)
LAYOUT := build/layout
# Each worker begins with a stretch of neighbours, which share what is compiled for them.
SPREAD := -n auto --dist worksteal
# They start a hundred processes, which do not compile the sources anew each, whatever is set.
PYTEST := PYTHONDONTWRITEBYTECODE= $(BIN)/python -m pytest $(if $(STRICT),-W error)

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

.PHONY: demo view derive test test-times check check-clean check-all check-newest check-lowest check-package check-joints \
	faults lint types pages nightly lock bench bench-rhs bench-many bench-heyoka bench-study bench-engine bench-workers bench-load \
	bench-kills bench-analyse bench-exponents bench-cycles bench-tables bench-live verdicts tolerance docs reference figures screenshot thesis audit report guide clean

demo: $(VENV)/installed
	@$(BIN)/rodgen derive 20 --out generated
	@$(BIN)/rodgen run scenes/missile.toml

view: $(VENV)/viewing
	@$(BIN)/rodgen view "$(SCENE)"

derive: $(VENV)/installed
	@$(BIN)/rodgen derive "$(N)" --boundary "$(BOUNDARY)" --inertia "$(INERTIA)" \
		--terms "$(TERMS)" --target "$(TARGET)" --form "$(FORM)" --parts "$(PARTS)" \
		$(if $(STEPS),--with-steps) $(if $(EXPLICIT),--explicit) --out generated

test: $(VENV)/developing
	$(PYTEST) $(SPREAD) --times test

test-times:
	@$(BIN)/python -m tests.times $(COUNT)

# What takes one core each goes side by side, before the tests take both.
check: $(VENV)/developing $(VENV)/evidence
	@$(MAKE) --no-print-directory -j2 --output-sync=target CHECK=1 pages lint types reference
	$(PYTEST) $(SPREAD) --times check -m slow tests
	$(PYTEST) $(SPREAD) --times evidence evidence/tests

# The pieces of a page follow one another, in one worker.
pages: $(VENV)/developing $(VENV)/evidence
	$(PYTEST) --times pages docs

# In an empty folder, as on a machine that has nothing of it.
check-clean:
	@commit=$$(git rev-parse HEAD) && start=$$(date +%s) && folder=$$(mktemp -d) && trap 'rm -rf "$$folder"' EXIT \
		&& git clone --quiet . "$$folder/rodgen" && cd "$$folder/rodgen" && git checkout --quiet --detach $$commit \
		&& env -u MAKEFLAGS -u MAKELEVEL -u MFLAGS CI=true bash .ci/run < /dev/null \
		&& cd "$(CURDIR)" && mkdir -p build && minutes=$$(( ($$(date +%s) - start + 59) / 60 )) \
		&& echo "$$commit is green after $$minutes minutes" | tee -a build/checked

check-all: test check nightly faults

nightly: docs $(VENV)/evidence
	$(PYTEST) $(SPREAD) --times nightly -m nightly tests evidence/tests
	$(PYTEST) -n auto -m nightly docs/site
	$(PYTEST) $(SPREAD) --doctest-modules $(EXAMPLES)

faults: $(VENV)/developing
	$(BIN)/python -m tests.mutation.seed $(if $(FROM),--from $(FROM)) $(if $(TO),--to $(TO)) $(if $(AGAIN),--again)

check-newest:
	$(MAKE) VENV=build/newest LOCK= STRICT=1 test check nightly

check-lowest: $(VENV)/developing
	@mkdir -p build && $(call compile,--resolution lowest-direct,"-e .[dev]",build/lowest.lock)
	$(MAKE) VENV=build/lowest LOCK=build/lowest.lock test

# What pip installs, alone in an environment, away from the clone; on Windows too, without a C compiler.
PACKAGE := $(CURDIR)/build/package/$(if $(filter Windows_NT,$(OS)),Scripts,bin)/python
check-package:
	$(PYTHON) -m venv --clear build/package
	$(PACKAGE) -m pip install --quiet .
	cd build && rm -f first.toml && $(PACKAGE) -m rodgen new first --from missile && $(PACKAGE) -m rodgen run first.toml --target numpy
	cd build && $(PACKAGE) -m rodgen critical --help > /dev/null

# Other tools, which the extra dev has not: their tests are skipped elsewhere.
check-joints: $(VENV)/developing
	$(INSTALL) --editable ".[dev,jax]" diffrax numba
	$(PYTEST) -m "slow or nightly or not nightly" tests/compiled/test_jax.py tests/compiled/test_functions.py docs/how-to

# One file for all Pythons and systems.
ALL := "-e .[dev,docs]" "-e evidence"
lock: $(VENV)/developing
	@$(call compile,--upgrade --universal --python-version 3.11,$(ALL),$(LOCK))

# The packages as they lie in a wheel: derive/, templates/ and scenes/ inside rodgen/.
$(LAYOUT): $(VENV)/developing $(VENV)/evidence
	@rm -rf $@ && mkdir -p $@
	@cp -R src/rodgen $@/rodgen && cp -R derive templates scenes $@/rodgen/ && cp -R evidence/src/rodgen_evidence $@/

lint: $(LAYOUT)
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/codespell $$(git ls-files | grep -vE '\.(svg|png|gif|json|netcdf|js|css)$$')
	$(BIN)/proselint --config .proselintrc.json check $$(git ls-files '*.md' | grep -v docs/audit.md)
	cd $(LAYOUT) && PYTHONPATH=$(CURDIR) $(abspath $(BIN))/lint-imports --config ../../pyproject.toml --no-logo

types: $(LAYOUT)
	cd $(LAYOUT) && $(abspath $(BIN))/mypy --config-file ../../pyproject.toml -p rodgen -p rodgen_evidence

.PHONY: $(LAYOUT)

bench: $(VENV)/evidence
	@$(BIN)/python -m rodgen_evidence.benchmarks.main_job

bench-rhs: $(VENV)/evidence
	@$(BIN)/python -m rodgen_evidence.benchmarks.rhs

bench-many: $(VENV)/evidence
	@$(BIN)/python -m rodgen_evidence.benchmarks.many

bench-heyoka: $(VENV)/evidence
	@$(BIN)/python -m rodgen_evidence.benchmarks.many_heyoka $(LINKS) $(if $(PLAIN),plain)

bench-study: $(VENV)/evidence
	@$(BIN)/python -m rodgen_evidence.benchmarks.study

bench-exponents: $(VENV)/evidence
	@$(BIN)/python -m rodgen_evidence.benchmarks.exponents

bench-cycles: $(VENV)/evidence
	@$(BIN)/python -m rodgen_evidence.benchmarks.cycles

bench-tables: $(VENV)/evidence
	@$(BIN)/python -m rodgen_evidence.benchmarks.tables

bench-analyse: $(VENV)/evidence
	@$(BIN)/python -m rodgen_evidence.benchmarks.analyse

bench-engine: $(VENV)/developing $(VENV)/evidence
	@$(BIN)/python -m rodgen_evidence.benchmarks.study_engine $(RUNS) $(TASKS)

bench-workers: $(VENV)/developing $(VENV)/evidence
	@$(BIN)/python -m rodgen_evidence.benchmarks.study_workers $(BLOCKS) $(WORKERS)

bench-load: $(VENV)/developing $(VENV)/evidence
	@$(BIN)/python -m rodgen_evidence.benchmarks.study_load $(TASKS) $(WORKERS)

bench-kills: $(VENV)/developing $(VENV)/evidence
	@$(BIN)/python -m rodgen_evidence.benchmarks.study_kills $(STUDIES)

verdicts: $(VENV)/evidence
	@$(BIN)/python -m rodgen_evidence.verdicts --scenes $(or $(SCENES),200)
	@$(BIN)/python -m rodgen_evidence.verdicts.wind

tolerance: $(VENV)/evidence
	@$(BIN)/python -m rodgen_evidence.tolerance --scenes $(or $(SCENES),300)

bench-live: $(VENV)/developing $(VENV)/evidence
	@$(BIN)/python -m rodgen_evidence.benchmarks.live $(or $(SECONDS),20) $(LINKS) $(if $(AGAINST),--against $(AGAINST))

reference: $(VENV)/developing
	$(BIN)/python -m tests.reference $(if $(CHECK),--check)

thesis: $(VENV)/evidence
	@$(BIN)/rodgen thesis

audit: $(VENV)/evidence
	@$(BIN)/rodgen audit

# Peers that cannot be had here are named on the page.
report: $(VENV)/peers
	@$(BIN)/rodgen report $(if $(QUICK),--quick) $(if $(RESUME),--resume)

# What docs/speed.md and docs/which-method.md show, from the report that was made last.
guide: $(VENV)/evidence
	@mkdir -p docs/report && cp results/report/report.json docs/report/
	@$(BIN)/python -m rodgen_evidence.pages.report_guide docs/report/report.json docs/speed.md docs/which-method.md

# The site, in build/site: open index.html there.
docs: $(VENV)/documenting
	@$(BIN)/python -m sphinx -W --keep-going -q -j auto docs build/site
	@echo "build/site/index.html"

figures: $(VENV)/evidence
	@$(BIN)/python -m rodgen_evidence.figures.model_figures docs/pictures
	@$(BIN)/python -m rodgen_evidence.figures.rocket_figures scenes/sounding_rocket.toml docs/pictures
	@$(BIN)/python -m rodgen_evidence.figures.branch_figures scenes docs/pictures
	@$(BIN)/python -m rodgen_evidence.figures.cycle_figures scenes docs/pictures

screenshot: $(VENV)/developing
	$(BIN)/python -m pytest -m nightly tests/live/test_appearance.py -k shows_a_rod --update

$(VENV)/bin/python:
	@$(PYTHON) -c "import sys; sys.exit(None if sys.version_info >= (3, 11) else \
		'rodgen needs Python 3.11 or later: make PYTHON=python3.12 ...')"
	@echo "setting up $(VENV)"
	@$(PYTHON) -m venv $(VENV)
	@# Else a folder that is called rodgen and lies beside a script, such as a clone, hides the package.
	@echo "$(CURDIR)/src" > "$$($@ -c 'import sysconfig; print(sysconfig.get_path("purelib"))')/rodgen_source.pth"

# What using rodgen needs; working on it needs more, and has this with it.
$(VENV)/installed: pyproject.toml $(LOCK) | $(VENV)/bin/python
	@$(INSTALL) --editable ".[c]"
	@touch $@

$(VENV)/viewing: pyproject.toml $(LOCK) | $(VENV)/installed
	@$(INSTALL) --editable ".[view]"
	@touch $@

$(VENV)/developing: pyproject.toml $(LOCK) | $(VENV)/bin/python
	@$(INSTALL) --editable ".[dev]"
	@touch $(VENV)/installed $@

$(VENV)/documenting: pyproject.toml $(LOCK) | $(VENV)/bin/python
	@$(INSTALL) --editable ".[docs]"
	@touch $(VENV)/installed $@

# What shows how far rodgen can be trusted: the commands report, thesis and audit.
$(VENV)/evidence: evidence/pyproject.toml $(LOCK) | $(VENV)/installed
	@$(INSTALL) --editable evidence
	@touch $@

$(VENV)/peers: evidence/pyproject.toml $(LOCK) | $(VENV)/evidence
	@$(INSTALL) --editable "evidence[peers]" \
		|| echo "not all peers can be installed here: the page names those that are missing"
	@touch $@

clean:
	rm -rf build results .pytest_cache .mypy_cache .ruff_cache .import_linter_cache

# make demo     the main job, end to end
# make view [SCENE=scenes/flutter.toml]     the live view, in a browser
# make derive N=20 [BOUNDARY=free] [INERTIA=uniform] [TERMS=all] [TARGET=numpy] [FORM=chain]
#             [PARTS=rhs,jac] [STEPS=1] [EXPLICIT=1]
# make test     the tests of every day
# make check    lint, types, slower tests, the live view in a browser, the pages of docs/
#      ONLY=lint | types | pages | reference | nightly    a part of it, or of check-all
#      ONLY=faults [FROM=1] [TO=20] [AGAIN=1]             every seeded fault, in copies
#      ONLY=newest | lowest      with the newest dependencies (warnings are errors), with the oldest
#      ONLY=package | joints     what pip installs, alone; with JAX, diffrax, Numba
# make check-clean      .ci/run (demo, test, check) in a clean clone of HEAD; if green, noted in build/checked
# make check-all        everything, and every seeded fault
# make bench [NAME=rhs] [ARGS=...]     a benchmark, a file of evidence's benchmarks: by default the main job;
#      NAME=tests [ARGS=40]    processor time of each test, of the last runs
# make report [NAME=...] [ARGS=...]    what shows how far rodgen can be trusted, into results/
#      by default error against run time, stability, extremes, beside peers (ARGS="--quick --resume");
#      NAME=thesis | audit       the tables of the thesis; its equations and listing
#      NAME=verdicts | tolerance    (ARGS="--scenes 200") random rods: stability against 50 digits and rests in a
#                                wind against plain continuation; errors of runs over their tolerances
# make docs     the site, in build/site
#      NAME=reference | figures | screenshot | guide    write anew the reference modules and the keys in docs/scenes.md; the
#                                figures of docs/derivation.md; the live view's picture; the numbers from the last report
# make lock     the versions of all dependencies
# make clean

PYTHON ?= python3
VENV ?= .venv
BIN := $(VENV)/bin
# Versions of all that is installed here; without it (LOCK=), the newest.
LOCK ?= requirements.lock
INSTALL = $(BIN)/python -m pip install --quiet --disable-pip-version-check $(addprefix --constraint ,$(LOCK))
# $(call compile,OPTIONS,REQUIREMENTS,FILE): the versions of all that REQUIREMENTS need.
compile = $(INSTALL) uv && printf '%s\n' $(2) | $(BIN)/python -m uv pip compile - --quiet --no-annotate --custom-compile-command "make lock" \
	--no-emit-package rodgen --no-emit-package rodgen-evidence --no-emit-package rodgen-live $(1) --output-file $(3)
LAYOUT := build/layout
# Each worker begins with a stretch of neighbours, which share what is compiled for them.
SPREAD := -n auto --dist worksteal
# They start a hundred processes, which do not compile the sources anew each, whatever is set.
PYTEST := PYTHONDONTWRITEBYTECODE= $(BIN)/python -m pytest $(if $(STRICT),-W error)

# Rooms whose public functions have examples.
EXAMPLES := $(addprefix src/rodgen/,scene loading native system integrate analyse studies result.py)

N ?= 20
BOUNDARY ?= free
INERTIA ?= uniform
TERMS ?= all
TARGET ?= numpy
FORM ?= chain
PARTS ?= all
SCENE ?= scenes/flutter.toml

.PHONY: demo view derive test check check-clean check-all bench report docs lock clean

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

check: $(if $(ONLY),$(addprefix .check-,$(ONLY)),.check-change)

# What takes one core each goes side by side, before the tests take both.
.check-change: $(VENV)/developing $(VENV)/evidence
	@$(MAKE) --no-print-directory -j2 --output-sync=target .check-pages .check-lint .check-types .check-reference
	$(PYTEST) $(SPREAD) --times check -m slow tests live/tests
	$(PYTEST) $(SPREAD) --times evidence evidence/tests

# The pieces of a page follow one another, in one worker.
.check-pages: $(VENV)/developing $(VENV)/evidence
	$(PYTEST) --times pages docs

.check-reference: $(VENV)/developing
	$(BIN)/python -m tests.reference --check

# In an empty folder, as on a machine that has nothing of it.
check-clean:
	@commit=$$(git rev-parse HEAD) && start=$$(date +%s) && folder=$$(mktemp -d) && trap 'rm -rf "$$folder"' EXIT \
		&& git clone --quiet . "$$folder/rodgen" && cd "$$folder/rodgen" && git checkout --quiet --detach $$commit \
		&& env -u MAKEFLAGS -u MAKELEVEL -u MFLAGS CI=true bash .ci/run < /dev/null \
		&& cd "$(CURDIR)" && mkdir -p build && minutes=$$(( ($$(date +%s) - start + 59) / 60 )) \
		&& echo "$$commit is green after $$minutes minutes" | tee -a build/checked

check-all: test check .check-nightly .check-faults

.check-nightly: .docs-site $(VENV)/evidence
	$(PYTEST) $(SPREAD) --times nightly -m nightly tests live/tests evidence/tests
	$(PYTEST) -n auto -m nightly docs/site
	$(PYTEST) $(SPREAD) --doctest-modules $(EXAMPLES)

.check-faults: $(VENV)/developing
	$(BIN)/python -m tests.mutation.seed $(if $(FROM),--from $(FROM)) $(if $(TO),--to $(TO)) $(if $(AGAIN),--again)

.check-newest:
	$(MAKE) ONLY= VENV=build/newest LOCK= STRICT=1 test check .check-nightly

.check-lowest: $(VENV)/developing
	@mkdir -p build && $(call compile,--resolution lowest-direct,"-e .[dev]" "-e live[dev]",build/lowest.lock)
	$(MAKE) ONLY= VENV=build/lowest LOCK=build/lowest.lock test

# What pip installs, alone in an environment, away from the clone; on Windows too, without a C compiler.
PACKAGE := $(CURDIR)/build/package/$(if $(filter Windows_NT,$(OS)),Scripts,bin)/python
.check-package:
	$(PYTHON) -m venv --clear build/package
	$(PACKAGE) -m pip install --quiet .
	cd build && rm -f first.toml && $(PACKAGE) -m rodgen new first --like missile && $(PACKAGE) -m rodgen run first.toml --target numpy
	cd build && $(PACKAGE) -m rodgen critical --help > /dev/null

# Other tools, which the extra dev has not: their tests are skipped elsewhere.
.check-joints: $(VENV)/developing
	$(INSTALL) --editable ".[dev,jax]" diffrax numba
	$(PYTEST) -m "slow or nightly or not nightly" tests/compiled/test_jax.py tests/compiled/test_functions.py docs/how-to

# One file for all Pythons and systems.
ALL := "-e .[dev,docs]" "-e evidence" "-e live[dev]"
lock: $(VENV)/developing
	@$(call compile,--upgrade --universal --python-version 3.11,$(ALL),$(LOCK))

# The packages as they lie in a wheel: derive/, templates/ and scenes/ inside rodgen/.
$(LAYOUT): $(VENV)/developing $(VENV)/evidence
	@rm -rf $@ && mkdir -p $@
	@cp -R src/rodgen $@/rodgen && cp -R derive templates scenes $@/rodgen/ && cp -R evidence/src/rodgen_evidence live/src/rodgen_live $@/

.check-lint: $(LAYOUT)
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/codespell $$(git ls-files | grep -vE '\.(svg|png|gif|json|netcdf|js|css)$$')
	$(BIN)/proselint --config .proselintrc.json check $$(git ls-files '*.md' | grep -v docs/audit.md)
	cd $(LAYOUT) && PYTHONPATH=$(CURDIR) $(abspath $(BIN))/lint-imports --config ../../pyproject.toml --no-logo

.check-types: $(LAYOUT)
	cd $(LAYOUT) && $(abspath $(BIN))/mypy --config-file ../../pyproject.toml -p rodgen -p rodgen_evidence -p rodgen_live

.PHONY: $(LAYOUT)

bench: $(VENV)/developing $(VENV)/evidence
	@$(BIN)/python -m $(if $(filter tests,$(NAME)),tests.times,rodgen_evidence.benchmarks.$(or $(NAME),main_job)) $(ARGS)

# Peers that cannot be had here are named on the page.
report: $(VENV)/$(if $(NAME),evidence,peers)
	@$(if $(filter verdicts tolerance,$(NAME)),$(BIN)/python -m rodgen_evidence.$(NAME),$(BIN)/rodgen $(or $(NAME),report)) $(ARGS)
	@$(if $(filter verdicts,$(NAME)),$(BIN)/python -m rodgen_evidence.verdicts.wind)

docs: .docs-$(or $(NAME),site)

.docs-site: $(VENV)/documenting
	@$(BIN)/python -m sphinx -W --keep-going -q -j auto docs build/site
	@echo "build/site/index.html"

.docs-reference: $(VENV)/developing
	$(BIN)/python -m tests.reference

.docs-figures: $(VENV)/evidence
	@$(BIN)/python -m rodgen_evidence.figures.model_figures docs/pictures
	@$(BIN)/python -m rodgen_evidence.figures.rocket_figures scenes/sounding_rocket.toml docs/pictures
	@$(BIN)/python -m rodgen_evidence.figures.branch_figures scenes docs/pictures
	@$(BIN)/python -m rodgen_evidence.figures.cycle_figures scenes docs/pictures

.docs-screenshot: $(VENV)/developing
	$(BIN)/python -m pytest -m nightly live/tests/test_appearance.py -k shows_a_rod --update

# What docs/speed.md and docs/which-method.md show, from the report that was made last.
.docs-guide: $(VENV)/evidence
	@mkdir -p docs/report && cp results/report/report.json docs/report/
	@$(BIN)/python -m rodgen_evidence.pages.report_guide docs/report/report.json docs/speed.md docs/which-method.md

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

$(VENV)/viewing: live/pyproject.toml $(LOCK) | $(VENV)/installed
	@$(INSTALL) --editable live
	@touch $@

$(VENV)/developing: pyproject.toml live/pyproject.toml $(LOCK) | $(VENV)/bin/python
	@$(INSTALL) --editable ".[dev]" --editable "live[dev]"
	@touch $(VENV)/installed $(VENV)/viewing $@

$(VENV)/documenting: pyproject.toml live/pyproject.toml $(LOCK) | $(VENV)/bin/python
	@$(INSTALL) --editable ".[docs]" --editable live
	@touch $(VENV)/installed $(VENV)/viewing $@

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

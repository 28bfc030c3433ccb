# The one entry to everything, the same by hand and in CI. `make` alone lists what there is.
PYTHON ?= python3
VENV   ?= .venv
BIN    := $(VENV)/bin

# One thread: results are then the same on every machine to the last printed digit, and small matrices are faster.
export OPENBLAS_NUM_THREADS ?= 1
export OMP_NUM_THREADS      ?= 1
export MKL_NUM_THREADS      ?= 1

# What a reader has in the home folder (kernels, IPython start-up files, matplotlib styles) stays out of the book.
export IPYTHONDIR              := $(abspath $(VENV))/ipython
export MPLCONFIGDIR            := $(abspath $(VENV))/matplotlib
export JUPYTER_PREFER_ENV_PATH := 1
export PIP_DISABLE_PIP_VERSION_CHECK := 1
unexport PYTHONPATH MPLBACKEND

# These tests open what has been built, and the picker in a browser.
BUILT := tests/pages/test_book.py tests/pages/test_live_page.py tests/pages/test_accessibility.py tests/pages/test_offline.py \
  tests/pages/test_picker_page.py tests/pages/test_picker_lab.py
NOTEBOOKS := $(sort $(wildcard notebooks/*.ipynb))

.DEFAULT_GOAL := help
.PHONY: help book pdf test lab notebooks edges picture data crosscheck study bench speed latency fuzz lint format unit slow nbval pages pyodide \
  portable html wheel screenshots clean distclean
.NOTPARALLEL:

help: ## list these targets
	@grep -E '^[a-z]+:.*##' $(MAKEFILE_LIST) | sed -E 's/^([a-z]+):.*## (.*)/  make \1\t\2/' | expand -t 20

# `make book OFFLINE=1` packs what the pages take from CDNs into the book; PYODIDE=folder has Python's part, if not its CDN.
ifdef OFFLINE
export RBFOUND_OFFLINE := $(abspath _build/offline)
html: _build/offline/offline.stamp
endif

book: $(VENV)/book.stamp html ## install, run and build the book, and say where to open it (OFFLINE=1: it needs no network)
	@echo
	@echo "The book is ready. Open this file in a browser:"
	@echo "  $(abspath _build/html/index.html)"

# A part that fails hides none after it; what failed is told at the end.
test: $(VENV)/dev.stamp ## install, and run all checks: lint, unit, wheel, html, nbval, pages (SLOW=1: the long tests, too)
	MAKE="$(MAKE)" $(BIN)/python tools/everything.py $(if $(SLOW),--slow)

lab: $(VENV)/book.stamp ## open the notebooks in JupyterLab (LAB=options, such as --no-browser)
	@if [ "$$(id -u)" = 0 ] && [ -z "$(findstring --allow-root,$(LAB))" ]; then \
	  echo "JupyterLab does not start for root, whose files any notebook could change. In a container: make lab LAB=--allow-root"; exit 1; fi
	$(BIN)/jupyter lab notebooks $(LAB)

notebooks: $(VENV)/book.stamp ## run the notebooks again and refresh their committed outputs
	$(BIN)/python tools/refresh_notebooks.py $(NOTEBOOKS)

picture: $(VENV)/book.stamp ## draw the README's picture again
	$(BIN)/python tools/overview.py book/static/overview.png book/static/social.png

data: $(VENV)/book.stamp ## compute the foundation's FRFs in data/ again from its solid model
	$(BIN)/python data/make_foundation.py

crosscheck: $(VENV)/book.stamp $(VENV)/ross.stamp $(VENV)/nastran.stamp ## compare with ROSS, pyNastran, Octave (if it is here) and CalculiX (needs ccx)
	$(BIN)/python tools/crosscheck_exports.py $(VENV)/ross/bin/python $(VENV)/nastran/bin/python
	$(BIN)/python tools/crosscheck.py

bench: benchmarks/.venv/bench.stamp benchmarks/.venv-ross/bench.stamp ## compare errors and CPU time with the peers, each at its pinned version
	benchmarks/.venv/bin/python benchmarks/identification.py
	benchmarks/.venv-ross/bin/python benchmarks/rotor.py
	benchmarks/.venv/bin/python benchmarks/startup.py
	benchmarks/.venv/bin/python benchmarks/sweep.py
	PYTHONPATH=tools benchmarks/.venv/bin/python benchmarks/solid.py

# A commit is timed by today's benchmarks, so that like stands beside like. `git worktree` keeps it in _build/at.
speed: benchmarks/.venv/bench.stamp ## time what is used most beside all runs before (AT=commit: how it was then)
	$(if $(AT),test -d _build/at/$(AT) || git worktree add --force --detach _build/at/$(AT) $(AT))
	PYTHONPATH=$(if $(AT),_build/at/$(AT),.) benchmarks/.venv/bin/pytest -W default benchmarks/test_speed.py \
	  --benchmark-timer=time.process_time --benchmark-columns=median,iqr,rounds --benchmark-sort=fullname \
	  --benchmark-save=$(or $(AT),now) --benchmark-compare

latency: $(VENV)/dev.stamp ## time how soon the built live page answers in a browser
	$(BIN)/python benchmarks/pages.py

study: $(VENV)/book.stamp ## identify two hundred noisy measurements: errors, and how often the error bars hold (15 minutes; an interrupt loses nothing)
	$(BIN)/python tools/study.py

lint: $(VENV)/dev.stamp ## ruff and mypy
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy

edges: $(VENV)/book.stamp ## list the notebooks' numbers that print differently on another processor, or nearly (an hour; NOTEBOOKS=...)
	$(BIN)/python tools/rounding_edges.py $(NOTEBOOKS)

format: $(VENV)/dev.stamp ## let ruff put code and notebooks in order
	$(BIN)/ruff check --fix .
	$(BIN)/ruff format .

# Two workers; of each file all tests go to one of them, which makes what they share once.
unit: $(VENV)/dev.stamp ## the package's own tests, but for the slow ones: some two minutes
	$(BIN)/pytest -m "not book and not slow" --numprocesses 2 --dist loadfile

slow: $(VENV)/dev.stamp ## the package's own tests that are long: whole studies, large files, kernels of Jupyter
	$(BIN)/pytest -m "slow and not book" --numprocesses 2 --dist loadfile

# atheris has wheels for Linux only; elsewhere Hypothesis does it alone
fuzz: $(VENV)/dev.stamp ## damage files of each format 10 000 times: nothing but a ValueError may come of it; other cases each time (RBFOUND_FUZZ=n)
	RBFOUND_FUZZ=$${RBFOUND_FUZZ:-2000} $(BIN)/pytest tests/files/test_fuzz.py
	RBFOUND_FUZZ=$${RBFOUND_FUZZ:-2000} $(BIN)/pytest -m hypothesis
	if $(BIN)/pip install --quiet --quiet "atheris>=3.0"; then $(BIN)/python tests/fuzz_atheris.py $${RBFOUND_FUZZ:-8000}; \
	  else echo "atheris is not to be had here: fuzzing by coverage is left out."; fi

nbval: $(VENV)/dev.stamp ## run the notebooks, and compare with their committed outputs
	$(BIN)/pytest --nbval --numprocesses 2 --dist loadfile $(NOTEBOOKS)

pages: $(VENV)/dev.stamp ## test the pages that `make book` has built, in a browser
	$(BIN)/pytest --numprocesses 2 --dist loadfile $(BUILT)

portable: $(VENV)/dev.stamp ## unit and nbval once for each kind of processor that this one can play (KERNEL=one, say Haswell)
	$(BIN)/python tools/kernels.py $(if $(KERNEL),--only $(KERNEL))

# Every page is read again; a notebook is run when it, the package, the data or the environment has changed (book/_ext/kept_runs.py).
html: $(VENV)/book.stamp # a warning is an error
	$(BIN)/jupyter-book build . --all -W --keep-going

# `make pages` needs it for the pages that compute; without it their tests are skipped. PYODIDE=folder as above.
pyodide: $(VENV)/dev.stamp ## fetch Python for the pages, some 50 MB, and check it against its list: for make pages
	$(BIN)/python tools/offline.py --only-pyodide _build/pyodide $(if $(PYODIDE),--pyodide "$(PYODIDE)")

_build/offline/offline.stamp: $(VENV)/book.stamp tools/offline.py
	$(BIN)/python tools/offline.py $(@D) $(if $(PYODIDE),--pyodide "$(PYODIDE)") $(if $(PACKAGES),--packages "$(PACKAGES)")
	@touch $@

pdf: $(VENV)/dev.stamp html ## the book as one PDF, _build/pdf/book.pdf (needs Chromium)
	$(BIN)/python tools/pdf.py _build/html _build/pdf/book.pdf $(if $(CDN),--cdn $(CDN))

wheel: $(VENV)/dev.stamp ## build the wheel, install it into an empty environment and import it there
	$(BIN)/python tools/check_wheel.py

screenshots: $(VENV)/dev.stamp html ## pictures of each page, wide and narrow, in _build/screenshots
	$(BIN)/python tools/screenshots.py _build/html _build/screenshots

clean: ## remove what was built; keep the environment
	rm -rf _build dist .pytest_cache .mypy_cache .ruff_cache .hypothesis

distclean: clean ## remove the environment too
	rm -rf $(VENV) benchmarks/.venv benchmarks/.venv-ross

$(VENV)/venv.stamp:
	@command -v $(PYTHON) >/dev/null || { \
	  echo "There is no '$(PYTHON)' here. rbfound needs Python 3.11 or newer; name it: make PYTHON=python3.12 $(MAKECMDGOALS)"; exit 1; }
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || { \
	  echo "rbfound needs Python 3.11 or newer, and '$(PYTHON)' is $$($(PYTHON) --version 2>&1)." \
	       "Name a newer one: make PYTHON=python3.12 $(MAKECMDGOALS)"; exit 1; }
	$(PYTHON) -m venv --clear $(VENV)
	@touch $@

# A kernel says at each start that it talks to the notebook without encryption; both are on this machine.
KERNEL_SETTINGS := $(VENV)/etc/ipython/ipython_kernel_config.py

# Building matplotlib's font list takes seconds and says so on stderr: once here, rather than in a notebook's cell.
$(VENV)/book.stamp: $(VENV)/venv.stamp pyproject.toml
	@echo "Installing into $(VENV): a minute or two the first time."
	$(BIN)/pip install --quiet --quiet --editable ".[book]"
	@mkdir -p $(dir $(KERNEL_SETTINGS)) && echo 'get_config().IPKernelApp.log_level = "ERROR"' > $(KERNEL_SETTINGS)
	$(BIN)/python -c "import matplotlib.font_manager"
	@touch $@

$(VENV)/dev.stamp: $(VENV)/book.stamp
	$(BIN)/pip install --quiet --quiet --editable ".[dev]"
	@touch $@

# ROSS and pyNastran each want other versions of what the book uses. What cannot be installed is left out of the check.
$(VENV)/ross.stamp: $(VENV)/venv.stamp pyproject.toml
	@echo "Installing ROSS into $(VENV)/ross: about 1 GB."
	$(PYTHON) -m venv --clear $(VENV)/ross
	if $(VENV)/ross/bin/pip install --quiet --quiet --editable ".[ross]"; then touch $@; else echo "ROSS is left out."; fi

$(VENV)/nastran.stamp: $(VENV)/venv.stamp
	$(PYTHON) -m venv --clear $(VENV)/nastran
	if $(VENV)/nastran/bin/pip install --quiet --quiet "pyNastran==1.4.1"; then touch $@; else echo "pyNastran is left out."; fi

# The peers would fight with the book's pins, and weigh more than it: an environment of their own.
benchmarks/.venv/bench.stamp: benchmarks/requirements.txt pyproject.toml
	@echo "Installing the peers into benchmarks/.venv: some minutes, and about 2.5 GB."
	$(PYTHON) -m venv --clear benchmarks/.venv
	benchmarks/.venv/bin/pip install --quiet --quiet --no-deps --requirement benchmarks/requirements.txt
	benchmarks/.venv/bin/pip install --quiet --quiet --no-deps --editable .
	@touch $@

benchmarks/.venv-ross/bench.stamp: benchmarks/requirements-ross.txt pyproject.toml
	@echo "Installing ROSS into benchmarks/.venv-ross: some minutes, and about 1.2 GB."
	$(PYTHON) -m venv --clear benchmarks/.venv-ross
	benchmarks/.venv-ross/bin/pip install --quiet --quiet --no-deps --requirement benchmarks/requirements-ross.txt
	benchmarks/.venv-ross/bin/pip install --quiet --quiet --no-deps --editable .
	@touch $@

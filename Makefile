# Every command sets up .venv when it has to; a second call installs nothing.

VENV   ?= .venv
PYTHON ?= $(shell command -v python3.11 || command -v python3)
# Where torch comes from, if not from where pip looks anyway. On Linux PyPI's torch brings CUDA packages; the CPU
# build: make dev TORCH_INDEX=https://download.pytorch.org/whl/cpu
TORCH_INDEX ?=

BIN := $(VENV)/bin
PIP := $(BIN)/python -m pip --disable-pip-version-check
INSTALL := $(PIP) install --quiet
# Exact versions and nothing but them: a file whose SHA-256 is not in the lock is refused.
INSTALL_LOCK := $(INSTALL) --no-deps --require-hashes --requirement

# What install and dev set up, of pyproject.toml's extras: what make run needs, and everything that is tested. The groups
# are the project's own.
RUN_EXTRAS := mujoco report
DEV_EXTRAS := mujoco sb3 report pybullet dm-control tensorboard wandb ray slurm video minari meshes xacro
RUN_GROUPS := build
DEV_GROUPS := dev docs

.PHONY: install dev lock run reference test kernels coverage slow plugins examples browser engines arms unity bench bench-record \
	quick-bench check docs links wheel sbom format clean

install: $(VENV)/.installed
dev: $(VENV)/.installed-dev

run: install
	$(BIN)/harness run --sim mujoco --algo sac --task fd100-small-target --reward dense --seeds 8

# A whole experiment and its committed records: make reference EXPERIMENT=arp_2021. Another file content, another folder
# of cells. Cells that failed, exit status 1, are part of the record; cells that are pending, told last, are an error.
# Of the figures those stay that a page shows.
# An experiment in a folder with a requirements.txt, EXPERIMENT=meta-world/reach, runs with what that names.
BESIDE := $(patsubst %requirements.txt,build/%installed,$(wildcard experiments/$(dir $(EXPERIMENT))requirements.txt))
reference: HARNESS = $(if $(BESIDE),$(dir $(BESIDE))bin/python -m harness,$(BIN)/harness)
reference: FILE = experiments/$(EXPERIMENT).toml
reference: HASH = import hashlib, sys; print(hashlib.sha256(open(sys.argv[1], 'rb').read()).hexdigest()[:8])
reference: CELLS = results/runs/$(EXPERIMENT)-$(shell $(BIN)/python -c "$(HASH)" $(FILE))
reference: RECORDS = results/reference/$(subst _,-,$(EXPERIMENT))
reference: dev $(BESIDE)
	$(if $(wildcard $(FILE)),,$(error Name a file: make reference EXPERIMENT=arp_2021, for experiments/arp_2021.toml))
	$(HARNESS) run $(FILE) --out $(CELLS) || [ $$? -eq 1 ]
	$(HARNESS) report $(CELLS) --summary $(RECORDS)
	$(BIN)/python docs/pictures/shown.py $(RECORDS)
	! grep ',pending,' $(RECORDS)/cells.csv

# Two processes, one thread each. Compiled modules are kept whatever the surroundings say: each of the many processes
# that tests start would compile all of them again.
test coverage: export PYTHONDONTWRITEBYTECODE =
test: dev
	OMP_NUM_THREADS=1 $(BIN)/python -m pytest -n 2 --benchmark-disable

# The same tests, and which lines and branches they ran, in the processes that they start too; pages into build/coverage.
# A room of which less than 90 % of the branches are run is an error. One room: make coverage TESTS=tests/eta.
coverage: TESTS =
coverage: dev
	mkdir -p build/coverage
	OMP_NUM_THREADS=1 $(BIN)/python -m pytest -n 2 --benchmark-disable --cov --cov-report=term \
		--cov-report=html:build/coverage/pages --cov-report=json:build/coverage/coverage.json $(TESTS)
	$(BIN)/python -m tests.rooms_covered build/coverage/coverage.json $(TESTS)

# Cells whose bits were recorded, and what learns them, under this machine's kernels of OpenBLAS and under older ones.
kernels: FILES = tests/experiment/test_golden_cells.py tests/compatibility/test_v0_1_0.py tests/plugins/fast_sac
kernels: dev
	OMP_NUM_THREADS=1 $(BIN)/python -m pytest $(FILES) -n 2 --benchmark-disable
	OPENBLAS_CORETYPE=Haswell OMP_NUM_THREADS=1 $(BIN)/python -m pytest $(FILES) -n 2 --benchmark-disable

slow: dev
	OMP_NUM_THREADS=1 $(BIN)/python -m pytest -m slow --benchmark-disable

# A new plugin of each kind, and the packages in examples/: written, installed and tested in a new environment each time.
# What an example needs besides is not in the lock: make examples skips it, and says which, where it is not installed.
plugins: dev
	OMP_NUM_THREADS=1 $(BIN)/python -m pytest tests/installed/test_plugin_packages.py -k "new_plugin or earlier" -m slow -n 2

examples: dev
	OMP_NUM_THREADS=1 $(BIN)/python -m pytest tests/installed/test_plugin_packages.py -k example -m '' -rs

# The pages in a Chromium that is installed; without one these tests are skipped, and say why.
browser: dev
	OMP_NUM_THREADS=1 $(BIN)/python -m pytest tests/report/test_browser.py tests/plugins/committed tests/report/page tests/report/replay \
		-m slow -rs --benchmark-disable

# The simulators that are in no lock, with what experiments/engines/requirements.txt names.
engines: ENGINES = build/experiments/engines/bin/python
engines: build/experiments/engines/installed
	$(ENGINES) -m harness check drake && $(ENGINES) -m harness check physx
	OMP_NUM_THREADS=1 $(ENGINES) -m pytest tests/plugins/simulators -k "drake or physx or test_mjx" -n 2 --benchmark-disable

# Public arms from packages of PyPI: loaded, trained in three simulators, and held against one another. Some: ARM='Z1 "KR16"'.
arms: ARM =
arms: build/experiments/arms/installed
	OMP_NUM_THREADS=1 build/experiments/arms/bin/python experiments/arms/measure.py results/reference/arms/arms.csv $(ARM)

# Unity's protocol, with a player that needs no Unity, and what experiments/unity/requirements.txt names.
unity: UNITY = build/experiments/unity/bin/python
unity: build/experiments/unity/installed
	OMP_NUM_THREADS=1 $(UNITY) -m pytest tests/plugins/unity_player tests/bench/timings/test_unity.py -n 2 --benchmark-disable
	OMP_NUM_THREADS=1 $(UNITY) -m pytest tests/bench/timings/test_unity.py -m bench -s

# Every bound of speed. make bench-record keeps the ratios, and draws those of all releases: one for each release.
bench: dev
	mkdir -p build
	BENCH_RECORD=build/bench.json OMP_NUM_THREADS=1 $(BIN)/python -m pytest tests/bench -m bench -s

bench-record: bench
	$(BIN)/python -m tests.bench.records build/bench.json results/reference/bench

# What takes seconds, so that a loss of speed is seen when it happens.
quick-bench: FILES = $(addprefix tests/bench/timings/test_,$(addsuffix .py,mujoco kinematic sac_fast policy score startup))
quick-bench: dev
	OMP_NUM_THREADS=1 $(BIN)/python -m pytest $(FILES) -m bench -s

check: dev
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/lint-imports
	$(BIN)/python -m tests.architecture

# The site, into build/site: a warning is an error.
docs: dev
	$(BIN)/python -m sphinx --builder html --fail-on-warning --keep-going --quiet docs build/site

# Every link out of the site is asked for, which takes a network; links inside are a test of their own.
links: dev
	$(BIN)/python -m sphinx --builder linkcheck --quiet docs build/links

# What users get: the archive and the wheel, every command and extra from that wheel, every `pip install` of the pages.
wheel: dev
	rm -rf dist
	$(BIN)/python -m build --no-isolation --quiet
	rm -rf *.egg-info # older than the next change of entry points, and Python would find it here
	$(BIN)/twine check --strict dist/*
	HARNESS_WHEEL=$$(ls dist/*.whl) OMP_NUM_THREADS=1 $(BIN)/python -m pytest tests/installed -m slow -n 2 --dist loadfile -rs \
		--deselect tests/installed/test_plugin_packages.py --benchmark-disable

# What a release is made with, by the locks, in CycloneDX's form: what make install sets up, and what make dev does. torch
# is in neither, see below.
sbom: SBOM = build/sbom/env/bin/python -m cyclonedx_py requirements --pyproject pyproject.toml
sbom: build/sbom/installed
	$(SBOM) --output-file build/sbom/fd100-harness-run.cdx.json requirements/run.txt
	$(SBOM) --output-file build/sbom/fd100-harness-dev.cdx.json requirements/dev.txt

format: dev
	$(BIN)/ruff check --fix .
	$(BIN)/ruff format .

clean:
	rm -rf $(VENV) build dist *.egg-info

# pip check: --no-deps asks for nothing, so only this says what a lock lacks on this platform.
$(VENV)/.installed: pyproject.toml constraints.txt requirements/run.txt
	@echo "Installing into $(VENV), once: a minute or two."
	test -x $(BIN)/python || $(PYTHON) -m venv $(VENV)
	$(INSTALL_LOCK) requirements/run.txt
	$(INSTALL) --no-deps --no-build-isolation --editable .
	$(PIP) check
	touch $@

# torch stands in no lock: its files differ by build and index. What it needs besides is there before it, from the lock.
$(VENV)/.installed-dev: $(VENV)/.installed requirements/dev.txt
	@echo "Installing what tests need beside it, once: some minutes, most of them for torch."
	$(INSTALL_LOCK) requirements/dev.txt
	$(INSTALL) --constraint constraints.txt $(if $(TORCH_INDEX),--index-url $(TORCH_INDEX)) torch
	$(PIP) check
	touch $@

# An environment of its own: what writes the list stands in no list.
build/sbom/installed: requirements/sbom.txt
	$(PYTHON) -m venv --clear $(@D)/env
	$(@D)/env/bin/python -m pip --disable-pip-version-check install --quiet --no-deps --require-hashes --requirement $<
	touch $@

# For experiments with packages that are in no lock: an environment that sees those of $(VENV) behind its own.
build/experiments/%/installed: experiments/%/requirements.txt $(VENV)/.installed-dev
	@echo "Installing what $< names. Where pip says that another package asks for another version: it is not used here."
	$(BIN)/python -m venv --without-pip --clear $(@D)
	$(BIN)/python -c "import sysconfig; print(f'import site; site.addsitedir({sysconfig.get_path(\"purelib\")!r})')" \
		> $$($(@D)/bin/python -c "import sysconfig; print(sysconfig.get_path('purelib'))")/above.pth
	$(PIP) --python $(@D) install --quiet --requirement $< $(if $(filter arms,$*),--no-deps)
	touch $@

# Versions stay that still fit pyproject.toml and constraints.txt. Newer ones: make lock UPGRADE=pytest, or UPGRADE=all.
lock: UV = $(BIN)/uv pip compile --quiet --universal --python-version 3.11 --fork-strategy fewest --generate-hashes \
	--custom-compile-command 'make lock'
lock: COMPILE = $(UV) --no-emit-package torch --excludes requirements/cuda.txt --constraint constraints.txt pyproject.toml
lock: NEWER = $(if $(filter all,$(UPGRADE)),--upgrade,$(addprefix --upgrade-package=,$(UPGRADE)))
lock: dev
	$(COMPILE) $(NEWER) $(addprefix --extra=,$(DEV_EXTRAS)) $(addprefix --group=,$(DEV_GROUPS)) \
		--output-file requirements/dev.txt
	$(COMPILE) --constraint requirements/dev.txt $(addprefix --extra=,$(RUN_EXTRAS)) \
		$(addprefix --group=,$(RUN_GROUPS)) --output-file requirements/run.txt
	$(UV) $(NEWER) --constraint requirements/dev.txt --group sbom --output-file requirements/sbom.txt

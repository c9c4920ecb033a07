# Every command sets up .venv when it has to; a second call installs nothing.

VENV   ?= .venv
PYTHON ?= $(shell command -v python3.11 || command -v python3)
# Where torch comes from, if not from where pip looks anyway. On Linux PyPI's torch brings CUDA packages; the CPU
# build: make install TORCH_INDEX=https://download.pytorch.org/whl/cpu
TORCH_INDEX ?=

BIN := $(VENV)/bin
PIP := $(BIN)/python -m pip install --quiet --disable-pip-version-check --constraint constraints.txt

.PHONY: install dev run reference test slow bench check format clean

install: $(VENV)/.installed
dev: $(VENV)/.installed-dev

run: install
	$(BIN)/harness run --sim mujoco --algo sac

# A whole experiment and its committed records: make reference EXPERIMENT=arp_2021. Cells that failed, exit status 1,
# are part of the record.
reference: dev
	$(if $(EXPERIMENT),,$(error Name it: make reference EXPERIMENT=arp_2021, for experiments/arp_2021.toml))
	$(BIN)/harness run experiments/$(EXPERIMENT).toml --out results/runs/$(EXPERIMENT) || [ $$? -eq 1 ]
	$(BIN)/harness report results/runs/$(EXPERIMENT) --summary results/reference/$(subst _,-,$(EXPERIMENT))

# Two processes, one thread each.
test: dev
	OMP_NUM_THREADS=1 $(BIN)/python -m pytest -n 2 --benchmark-disable

slow: dev
	OMP_NUM_THREADS=1 $(BIN)/python -m pytest -m slow --benchmark-disable

bench: dev
	OMP_NUM_THREADS=1 $(BIN)/python -m pytest tests/bench -m bench -s

check: dev
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/lint-imports

format: dev
	$(BIN)/ruff check --fix .
	$(BIN)/ruff format .

clean:
	rm -rf $(VENV) build dist *.egg-info

# torch first and alone: with it there, nothing else asks for another build of it.
$(VENV)/.installed: pyproject.toml constraints.txt
	test -x $(BIN)/python || $(PYTHON) -m venv $(VENV)
	$(PIP) $(if $(TORCH_INDEX),--index-url $(TORCH_INDEX)) torch
	$(PIP) --editable '.[mujoco,sb3,report]'
	touch $@

$(VENV)/.installed-dev: $(VENV)/.installed
	$(PIP) --editable '.[mujoco,pybullet,dm-control,sb3,report,figures,tune,tensorboard,dev]'
	touch $@

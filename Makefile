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

# A whole experiment and its committed records: make reference EXPERIMENT=arp_2021. Another file content, another folder
# of cells. Cells that failed, exit status 1, are part of the record; cells that are pending, told last, are an error.
reference: FILE = experiments/$(EXPERIMENT).toml
reference: HASH = import hashlib, sys; print(hashlib.sha256(open(sys.argv[1], 'rb').read()).hexdigest()[:8])
reference: CELLS = results/runs/$(EXPERIMENT)-$(shell $(BIN)/python -c "$(HASH)" $(FILE))
reference: RECORDS = results/reference/$(subst _,-,$(EXPERIMENT))
reference: dev
	$(if $(wildcard $(FILE)),,$(error Name a file: make reference EXPERIMENT=arp_2021, for experiments/arp_2021.toml))
	$(BIN)/harness run $(FILE) --out $(CELLS) || [ $$? -eq 1 ]
	$(BIN)/harness report $(CELLS) --summary $(RECORDS)
	! grep ',pending,' $(RECORDS)/cells.csv

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

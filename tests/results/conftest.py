"""Small experiments, made by hand."""

from weakref import WeakSet

import pytest

from harness import load_results
from harness.experiment.plan import check_experiment, expand
from harness.record import read_trace
from tests.results.folders import ARP, ARP_RUNS, BASELINE, BASELINE_RUNS, finish
from tests.results.gentle import run_gentle
from tests.results.in_looks import folder_in_looks
from tests.stores import create_store

TOY = {
    "sim": "ideal", "algo": "narrate", "task": "fd100-reach:horizon=5", "seeds": 2, "steps": 12,
    "evaluation_episodes": 3, "reward": "arp,dense",
}  # fmt: skip


@pytest.fixture
def both(make_cell):
    """Cells of two rewards for each of so many seeds."""
    return lambda seeds, rewards=(BASELINE, ARP), **fields: [
        make_cell(seed=seed, reward=reward, **fields) for seed in range(seeds) for reward in rewards
    ]


@pytest.fixture
def made(make_plan, registry, tmp_path):
    """Opens an experiment of cells, each left as `how` says, see `finish`; one of which it says None has not run."""

    def make(cells, how=lambda cell: {}, *, plugins=registry, **plan):
        store = create_store(tmp_path / "made", make_plan(*cells, **plan))
        for cell in cells:
            if (given := how(cell)) is not None:
                finish(store, cell, **given)
        return load_results(store.folder, registry=plugins)

    return make


@pytest.fixture
def experiment(both, made):
    """Three seeds of both rewards, all done."""
    return made(both(3), lambda cell: {"distances": (ARP_RUNS if cell.reward == ARP else BASELINE_RUNS)[cell.seed]})


@pytest.fixture
def folder_of(make_cell, make_plan, registry, tmp_path):
    """An experiment that trains in looks, nothing done yet."""
    return lambda terms: folder_in_looks(terms, make_cell, make_plan, registry, tmp_path)


@pytest.fixture(scope="session")
def ran(tmp_path_factory):
    """Trainings with a reward that has terms, and with the baseline."""
    return run_gentle(tmp_path_factory.mktemp("gentle"), reward=["gentle"])


@pytest.fixture
def ran_toys(toys, run_once, run_here, tmp_path):
    """Two seeds of some rewards, run by a toy; anew, or copied where a test ran the same before."""

    def run(*, anew=False, **given):
        asked = {**TOY, **given}
        return (run_here if anew else run_once)(expand(check_experiment(asked), toys), tmp_path / "out")

    return run


class Reads:
    """Reads traces, and remembers which."""

    def __init__(self):
        self.files, self.held, self.most = [], WeakSet(), 0

    @property
    def names(self):
        """Names of the files that were read."""
        return {path.name for path in self.files}

    def __call__(self, path, *, most):
        """Read one."""
        self.files.append(path)
        trace = read_trace(path, most=most)
        self.held.add(trace)
        self.most = max(self.most, len(self.held))
        return trace


@pytest.fixture(name="reads")
def _reads(monkeypatch):
    """Traces that results read."""
    reads = Reads()
    monkeypatch.setattr("harness.results.cell_results.read_trace", reads)
    return reads

"""Every algorithm learns the FD100 task: trained and evaluated as by `harness run`, it is far better than random."""

import pyarrow.parquet as pq
import pytest

import harness
from harness.record import EVALUATION, RANDOM, read_trace
from harness.record.trace import mean_return

pytestmark = pytest.mark.slow
SEEDS = 3
STEPS = {"sb3-sac": 5_000, "td3": 6_000, "ppo": 15_000, "dqn": 4_000, "ddqn": 4_000}
"""Environment steps, as few as make it clear."""


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    """The results of an algorithm on a task, of three seeds under the reward `dense`."""
    done = {}

    def run(algorithm, task):
        if (algorithm, task) not in done:
            folder = tmp_path_factory.mktemp(algorithm)
            done[algorithm, task] = harness.run(
                sim="kinematic", algo=algorithm, task=task, reward="dense", baseline="dense", seeds=SEEDS,
                steps=STEPS[algorithm], jobs=1, out=folder,
            )  # fmt: skip
        return done[algorithm, task]

    return run


CASES = [(name, "fd100-reach") for name in STEPS] + [("ppo", "fd100-reach:action=discrete")]


@pytest.mark.parametrize(("algorithm", "task"), CASES)
def test_algorithm_reaches_what_random_does_not(results, algorithm, task):
    """Of 100 targets the policy of every seed reaches 70 and more, random actions 10 at most."""
    found = pq.read_table(results(algorithm, task).write_table()).to_pydict()
    assert len(found["seed"]) == 2 * SEEDS  # the baseline is its own control
    assert min(found["success_rate"]) >= 0.7
    assert max(found["random_success_rate"]) <= 0.1


@pytest.mark.parametrize(("algorithm", "task"), CASES)
def test_algorithm_earns_what_random_does_not(results, algorithm, task):
    """The mean return of every seed's policy is at least 20 above that of random actions, -40 and less."""
    found = results(algorithm, task)
    [path] = found.store.folder.rglob(RANDOM)  # one for all seeds
    random = mean_return(read_trace(path))
    assert random is not None
    for cell in found.done_cells:
        trained = mean_return(read_trace(found.store.cell_folder(cell) / EVALUATION))
        assert trained is not None
        assert trained > random + 20.0

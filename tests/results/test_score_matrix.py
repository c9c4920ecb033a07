"""Every training under every ruler."""

import json
from collections.abc import Callable
from importlib.metadata import EntryPoint, entry_points

import numpy as np

from harness.eta.curve import curve_of
from harness.record.store import Store
from harness.registry.choice import choose
from harness.registry.registry import Registry, load_registry
from harness.results import Results
from harness.results.score_matrix import score_matrices
from tests.results.folders import ARP_RUNS, BASELINE_RUNS, paid
from tests.results.test_traces import BROKEN

RUNS = {"baseline": BASELINE_RUNS, "arp": ARP_RUNS}
GAINS = {"baseline": 1.0, "arp": 1.5}


def test_each_training_has_an_index_under_each_reward(experiment: Store, registry: Registry):
    """That of what the reward would have paid its runs, worked out apart."""
    results = Results(experiment.folder, registry)
    (matrix,) = score_matrices(results, [choose(registry, "rewards", name) for name in RUNS], registry)
    assert matrix.seeds == {"baseline": (0, 1, 2), "arp": (0, 1, 2)}
    assert matrix.failed == {}
    for scoring, gain in GAINS.items():
        for training, runs in RUNS.items():
            expected = curve_of([np.array(paid(run, gain)) for run in runs.values()]).index
            assert matrix.indices[scoring][training] == expected
    data = json.loads(json.dumps(matrix.to_json(), allow_nan=False))
    assert set(data["indices"]["arp"]) == {"baseline", "arp"}


def test_a_reward_that_cannot_score_a_training_costs_its_own_entry(
    experiment: Store, write_plugin: Callable[..., EntryPoint]
):
    """What it could score is there, and why it could not score the rest."""
    source = BROKEN.replace("DO", "raise ZeroDivisionError('by nothing')")
    registry = load_registry([*entry_points(group="harness"), write_plugin(source, "broken")])
    scoring = [choose(registry, "rewards", name) for name in ("broken", "baseline")]
    (matrix,) = score_matrices(Results(experiment.folder, registry), scoring, registry)
    assert (list(matrix.indices["broken"]), list(matrix.indices["baseline"])) == (["arp"], ["baseline", "arp"])
    assert "ZeroDivisionError: by nothing" in matrix.failed["broken"]

"""Every training under every ruler."""

import json
from importlib.metadata import entry_points

import numpy as np

from harness import load_registry
from harness.eta import curve_of
from harness.registry import choose
from harness.results.score_matrix import score_matrices
from tests.results.folders import ARP_RUNS, BASELINE_RUNS, paid
from tests.results.test_traces import BROKEN


def _matrix(results, registry, *names):
    (matrix,) = score_matrices(results, [choose(registry, "rewards", name) for name in names], registry)
    return matrix


def test_each_training_has_an_index_under_each_reward(experiment, registry):
    """That of what the reward would have paid its runs, worked out apart."""
    matrix = _matrix(experiment, registry, "baseline", "arp")
    assert (matrix.seeds, matrix.failed) == ({"baseline": (0, 1, 2), "arp": (0, 1, 2)}, {})
    for scoring, gain in {"baseline": 1.0, "arp": 1.5}.items():
        for training, runs in {"baseline": BASELINE_RUNS, "arp": ARP_RUNS}.items():
            expected = curve_of([np.array(paid(run, gain)) for run in runs.values()]).index
            assert matrix.indices[scoring][training] == expected
    assert set(json.loads(json.dumps(matrix.to_json(), allow_nan=False))["indices"]["arp"]) == {"baseline", "arp"}


def test_a_reward_that_cannot_score_a_training_costs_its_own_entry(experiment, write_plugin):
    """What it could score is there, and why it could not score the rest."""
    source = BROKEN.replace("DO", "raise ZeroDivisionError('by nothing')")
    registry = load_registry([*entry_points(group="harness"), write_plugin(source, "broken")])
    matrix = _matrix(experiment, registry, "broken", "baseline")
    assert (list(matrix.indices["broken"]), list(matrix.indices["baseline"])) == (["arp"], ["baseline", "arp"])
    assert "ZeroDivisionError: by nothing" in matrix.failed["broken"]

"""Recorded runs scored by a reward, or why they cannot be."""

import numpy as np
import pytest

from harness.record.trace import Trace
from harness.registry.choice import Choice, choose
from harness.registry.registry import Registry, load_registry
from harness.score.scored_runs import score_runs
from harness.score.scorer import score_trace


@pytest.fixture(scope="module")
def registry() -> Registry:
    """The installed plugins."""
    return load_registry()


@pytest.fixture
def run() -> Trace:
    """One episode whose rewards nobody has filled in."""
    distance = np.array([1.0, 1.5, 0.5, 0.25])
    flags = dict.fromkeys(("reached", "terminated", "truncated"), np.zeros(4, bool))
    columns = {
        "env": np.zeros(4, int),
        "step": np.arange(4),
        "begin_distance": np.ones(4),
        "previous_best": np.array([1.0, 1.0, 1.0, 0.5]),
        "distance": distance,
        "reward": np.zeros(4),
    }
    return Trace({**columns, **flags})


def _paid(run: Trace, reward: Choice, registry: Registry) -> Trace:
    return Trace({**run.columns, "reward": score_trace(reward.build(registry, "rewards"), run)})


def test_runs_are_scored(run: Trace, registry: Registry):
    """As the reward pays them, in their order, without a reason."""
    reward = choose(registry, "rewards", "arp")
    scored = score_runs(reward, registry, _paid(run, reward, registry), [run, run])
    assert scored.reason == ""
    np.testing.assert_array_equal(scored.values, [_paid(run, reward, registry)["reward"]] * 2)


def test_reward_that_has_changed_says_so(run: Trace, registry: Registry):
    """It does not pay what is recorded."""
    scored = score_runs(choose(registry, "rewards", "arp"), registry, run, [run])
    assert scored.values is None
    assert scored.reason == "reward arp pays its own recorded steps otherwise than then: it has changed"


def test_reward_without_a_record_is_taken_as_it_is(run: Trace, registry: Registry):
    """There is nothing that it could have changed from."""
    assert score_runs(choose(registry, "rewards", "arp"), registry, None, [run]).reason == ""


def test_reward_that_is_gone_says_so(run: Trace, registry: Registry):
    """With the message of the registry."""
    scored = score_runs(Choice("gone", (), "gone"), registry, None, [run])
    assert scored.values is None
    assert scored.reason.startswith("No reward 'gone'")

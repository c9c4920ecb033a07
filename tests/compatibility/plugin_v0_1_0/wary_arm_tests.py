"""The tests that the package had, in the words of version 0.1.0's contract kit; run by test_plugin_v0_1_0.py."""

import pytest
from wary_arm.metric import Way
from wary_arm.reward import Half, Wary
from wary_arm.simulator import Still

from harness.testing import METRIC_CHECKS, REWARD_CHECKS, check_metric, check_reward, violations
from harness.testing.ideal import IdealSimulator
from harness.testing.samples import random_samples
from harness.testing.simulations import NUM_ENVS


@pytest.mark.parametrize("check", REWARD_CHECKS, ids=lambda check: check.__name__)
def test_reward(check):
    """Each check by itself."""
    check(Wary())


def test_all():
    """All of them."""
    check_reward(Half())
    check_metric(Way())
    assert not list(violations(METRIC_CHECKS, Way()))


def test_helpers():
    """What the kit had beside its checks."""
    assert random_samples is not None
    assert NUM_ENVS > 0
    assert type(IdealSimulator()).__name__ == "IdealSimulator"
    assert Still().steps == 20

"""What a reward costs that reads more than distances, or has terms, beside the baseline."""

import numpy as np
import pytest
from numpy.random import default_rng

from harness.env.vector_env import ReachVectorEnv
from harness.registry import choose
from harness.reward.forms import reward_class
from harness.task import ReachTask
from tests.registered import FD100 as ROBOT, REGISTRY

pytestmark = pytest.mark.bench


def one(step):
    """What `terms` pays, as one number."""
    return -step.distance - 0.01 * (step.action**2).sum(-1) - 0.1 * ((step.action - step.before.action) ** 2).sum(-1)


def terms(step):
    """Reach the target, and move little."""
    return {
        "reach": -step.distance,
        "effort": -0.01 * (step.action**2).sum(-1),
        "jerk": -0.1 * ((step.action - step.before.action) ** 2).sum(-1),
    }


def asks(step):
    """Nearness, and what a step does not tell here."""
    return -step.distance + getattr(step, "reached", 0.0)


@pytest.mark.parametrize("num_envs", [1, 64, 1024])
@pytest.mark.parametrize("function", [one, terms, asks])
def test_a_step_costs_little_more(require_speed, step_through, amount, function, num_envs):
    """Without dynamics, where a reward is the largest part of a step that it can be."""
    simulator = choose(REGISTRY, "simulators", "kinematic").build(REGISTRY, "simulators")
    rewards = choose(REGISTRY, "rewards", "baseline").build(REGISTRY, "rewards"), reward_class(function)()
    baseline, more = (ReachVectorEnv(simulator, ROBOT, ReachTask(), reward, num_envs) for reward in rewards)
    count = amount({1: 3000, 64: 1500, 1024: 300}[num_envs], 2)
    actions = default_rng(0).uniform(-1.0, 1.0, (count, num_envs, 6)).astype(np.float32)
    for env in (baseline, more):
        env.reset(seed=0)
    require_speed(lambda: step_through(baseline, actions), lambda: step_through(more, actions), at_least=1 / 1.1)

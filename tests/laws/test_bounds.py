"""No interval leaves what a measure can be, at every door that says what behaviour was like."""

import subprocess
import sys

import gymnasium
import numpy as np
import pytest
from gymnasium.spaces import Box, Discrete
from hypothesis import given, strategies as st

import harness
from harness import load_results
from harness.eta import SHARE, mean_over_seeds
from harness.payoff.rollout import record_rollouts
from harness.results.recordings.episodes import Episodes
from harness.task import ReachTask
from harness_plugins.audit import audit_recordings, audit_reward, audit_rewards
from harness_plugins.audit.recorded.earned import earned_by
from harness_plugins.audit.recorded.experiment import audit_experiment
from harness_plugins.kit import IdealSimulator
from harness_plugins.rewards.dense import Dense
from tests.registered import FD100

EPISODES = 10


class Rare(gymnasium.Env):
    """Episodes of one step, of which one in thirty succeeds, and one goes far."""

    observation_space, action_space = Box(0.0, 1.0, (1,)), Discrete(2)
    count = 0

    def reset(self, *, seed=None, options=None):
        super().reset(seed=seed)
        return np.zeros(1, np.float32), {}

    def step(self, action):
        self.count += 1
        is_rare = self.count % 30 == 0
        return np.zeros(1, np.float32), float(action), True, False, {"success": is_rare, "far": 5.0 * is_rare}


MEASURES = {"behaviour": {"success": "success", "far": "far"}, "bounds": {"far": (0.0, np.inf)}}


def of_environment(folder):
    """Of random actions."""
    return audit_rewards(Rare, {"even": lambda *step: 1.0}, episodes=EPISODES, **MEASURES)


def of_recordings(folder):
    """Of trainings that were recorded, the first of which succeeded once, early."""
    for seed in range(3):
        env = Rare()
        env.count = 28 * (seed == 0)
        told = {"trained_with": "own", "rewards": {"own": "own"}, "seed": seed, **MEASURES}
        with harness.RecordRewards(env, folder / str(seed), **told) as recorded:
            for _ in range(2 * EPISODES):
                recorded.reset()
                recorded.step(1)
    return audit_recordings(folder)


def of_arm(folder):
    """Of scripted movements, some of which never reach the target."""
    return audit_reward(Dense(), Dense(), record_rollouts(IdealSimulator(), FD100, ReachTask(), EPISODES), 0.95)


def of_experiment(folder):
    """Of arms that move at random."""
    run = "run --sim kinematic --algo random --reward dense --seeds 3 --steps 200 --evaluation-episodes 2 --out done"
    command = [sys.executable, "-m", "harness", *run.split()]
    subprocess.run(command, cwd=folder, check=True, capture_output=True)
    return audit_experiment(load_results(folder / "done"), ())


@pytest.mark.parametrize("door", [of_environment, of_recordings, of_arm, of_experiment], ids=lambda it: it.__name__)
def test_a_share_of_episodes_stays_between_0_and_1(tmp_path, door):
    """And nothing that happened rarely, or never, is said to be certain."""
    told = [it.measures.get("success") or it.measures["success_rate"] for it in door(tmp_path).earned]
    rare = [it for it in told if it.low is not None and it.value < 0.1]
    assert rare
    assert all(0.0 <= it.low <= it.value < it.high <= 1.0 for it in rare)


@pytest.mark.parametrize("door", [of_environment, of_recordings], ids=lambda it: it.__name__)
def test_an_interval_stays_within_what_was_said(tmp_path, door):
    """A distance is not below 0, though one episode in thirty is far from all others."""
    told = [it.measures["far"] for it in door(tmp_path).earned]
    assert all(it.low >= 0.0 for it in told if it.low is not None)
    assert any(it.value > 0.0 for it in told)


@given(values=st.lists(st.booleans(), min_size=3, max_size=40))
def test_an_interval_holds_its_mean_and_stays_within_bounds(values):
    """Whatever the episodes did."""
    flags = np.array(values, float)
    found = earned_by("any", [Episodes(np.arange(len(flags)), {}, {"success": flags}, {})], (), {"success": SHARE})
    told = found.measures["success"]
    assert 0.0 <= told.low <= told.value <= told.high <= 1.0
    assert told.low < told.high


def test_without_bounds_it_leaves_them():
    """What the doors guard against: Student's interval of one success in thirty."""
    assert mean_over_seeds([1.0] + 29 * [0.0]).low < 0.0

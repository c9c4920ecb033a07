"""What tests of the env need: one without an engine, and ways to move in it."""

import numpy as np
import pytest
from numpy.random import default_rng

from harness.env.vector_env import ReachVectorEnv
from harness.record import TraceWriter, read_trace
from harness.registry import choose
from harness.robot import reach_position
from harness.task import ReachTask
from harness_plugins.kit import IdealSimulator
from harness_plugins.kit.trainings import NegativeDistance
from tests.registered import FD100 as ROBOT, REGISTRY

SHORT = ReachTask(horizon=4)
SHORT_TASK = {"name": "fd100-reach", "horizon": 23}
UNITY = {"name": "unity-reach", "horizon": 60, "decision_period": 5}
TASKS = {
    "joints": SHORT_TASK,
    "poses": {**SHORT_TASK, "action": "set-joints"},
    "arcs": {**SHORT_TASK, "action": "movea"},
    "long decisions": {**UNITY, "action": "movej"},
    "next targets": UNITY,
    "choices": {**SHORT_TASK, "action": "discrete"},
    "a goal that moves": {"name": "fd100-moving", "horizon": 12},
    "a goal that turns": {"name": "fd100-pose", "horizon": 12},
    "worse": {
        **SHORT_TASK,
        "joint_noise": 0.02,
        "target_noise": 0.01,
        "action_noise": 0.1,
        "action_delay": 2,
        "observation_delay": 3,
        "obstacle_count": 2,
        "mass_variation": 0.2,
        "length_variation": 0.05,
        "variants": 2,
    },
}
"""Of each kind one, as they are given."""


def build(kind, given):
    """By its registered name."""
    return choose(REGISTRY, kind, given).build(REGISTRY, kind)


class CountsSteps(NegativeDistance):
    """Pays the number of steps since it last began."""

    def initial_carry(self, begin_distance):
        """None yet."""
        return (begin_distance * 0.0,)

    def __call__(self, carry, sample):
        """One more."""
        return (carry[0] + 1.0,), carry[0] + 1.0


def _make(num_envs=1, task=SHORT, seed=None, **options):
    given = {"simulator": IdealSimulator(), "robot": ROBOT, "task": task, "reward": NegativeDistance(), **options}
    env = ReachVectorEnv(num_envs=num_envs, **given)
    if seed is not None:
        env.reset(seed=seed)
    return env


def _stand(env):
    return env.step(np.zeros((env.num_envs, 6), np.float32))


def _wander(env, steps, seed=0):
    rng = default_rng(seed)
    shape = env.action_space.shape
    return [env.step(rng.uniform(-1.0, 1.0, shape).astype(np.float32)) for _ in range(steps)]


def _drive_to(env, position):
    goal, reached = reach_position(ROBOT, position, env.simulation.read().qpos)
    assert reached.all()
    for _ in range(100):
        way = goal - env.simulation.read().qpos
        taken = env.step((way / (0.1 * env.task.speed * ROBOT.max_speed)).astype(np.float32))
        if (taken[2] | taken[3]).any():
            return taken
    raise AssertionError("no episode ended")


def _first_observations(env, episodes, action_seed):
    seen = [env.reset(seed=11)[0]]
    for _ in range(episodes - 1):
        observations, _, terminated, truncated, _ = _wander(env, env.task.horizon, action_seed)[-1]
        assert (truncated & ~terminated).all()
        seen.append(observations)
    return np.array(seen)


@pytest.fixture
def make():
    """An env without an engine; reset where a seed is given."""
    return _make


@pytest.fixture
def recorded(tmp_path):
    """The trace of an env that is reset with a seed, and then does what a function of it does."""

    def record(env, go, seed=0):
        path, episodes = tmp_path / "trace.parquet", env.episodes
        with TraceWriter(path, env.robot.dof, episodes.action.shape[1], extras=episodes.extras) as env.recorder:
            env.reset(seed=seed)
            go(env)
        env.close()
        return read_trace(path)

    return record


@pytest.fixture
def stand():
    """One step without motion."""
    return _stand


@pytest.fixture
def wander():
    """Steps with random actions."""
    return _wander


@pytest.fixture
def drive_to():
    """Drive the end effectors of all envs to a position until an episode ends; the last step."""
    return _drive_to


@pytest.fixture
def first_observations():
    """The first observations of several episodes, (episodes, num_envs, size), under random actions between."""
    return _first_observations


@pytest.fixture
def target_of():
    """The target as it is observed."""
    return lambda observations: observations[:, 18:21]

"""An env that is put where another stood goes on as that one does, bit for bit, whatever the simulator."""

from typing import Any

import numpy as np
import pytest

import harness
from harness.env.ideal import IdealSimulation
from harness.env.vector_env import ReachVectorEnv, World
from harness.errors import SchemaError
from harness.task import ReachTask
from harness_plugins.kit import IdealSimulator
from harness_plugins.kit.trainings import NegativeDistance
from tests.env.conftest import REGISTRY, SHORT_TASK, TASKS, build
from tests.refusals import refused
from tests.registered import FD100 as ROBOT


def _moments(episode):
    """Decisions after which the env's state is taken: early and late in episodes, and where one has just begun."""
    return 1, episode - 1, episode, 8 * episode // 3


def _open(simulator, task, num_envs, reward="baseline"):
    goal = build("tasks", task)
    robot = harness.load_robot(goal.robot, REGISTRY)
    return World(build("simulators", simulator), robot, goal, build("rewards", reward)).open(num_envs, resumable=True)


def _actions(env, count):
    """Mostly down: the arms come near the ground, and touch it."""
    env.action_space.seed(3)
    actions = [env.action_space.sample() for _ in range(count)]
    if actions[0].dtype != np.float32:
        return actions
    way = np.array([0.1, 0.9, 0.6, 0.3, 0.3, 0.0], np.float32)[: actions[0].shape[1]]
    return [np.clip(way[: action.shape[1]] + 0.4 * action, -1.0, 1.0) for action in actions]


def _told(env, actions):
    """Everything that an env tells, and where its episodes stand, action by action."""
    told = []
    for action in actions:
        *arrays, infos = env.step(action)
        told.append([*arrays, *(infos[name] for name in sorted(infos)), env.episodes.matrix.copy()])
    return told


def _is_same(first, second):
    return all(
        np.array_equal(one, other)
        for ones, others in zip(first, second, strict=True)
        for one, other in zip(ones, others, strict=True)
    )


@pytest.mark.parametrize(
    ("simulator", "task", "num_envs"),
    [*((simulator, "joints", num_envs) for simulator in REGISTRY.names("simulators") for num_envs in (1, 3)),
     *(("kinematic", task, 3) for task in TASKS if task != "joints"),
     ("mujoco", "next targets", 3), ("mujoco", "arcs", 1),
     ("mujoco", "worse", 1), ("pybullet", "long decisions", 3), ("pybullet", "poses", 1)],
)  # fmt: skip
def test_restored_env_goes_on_as_the_other(installed, simulator, task, num_envs):
    """Observations, rewards, ends, infos and the whole record, in the middle of episodes and where they end."""
    env = _open(simulator, TASKS[task], num_envs)
    env.reset(seed=5)
    episode = TASKS[task]["horizon"] // TASKS[task].get("decision_period", 1)
    moments = _moments(episode)
    actions, states = _actions(env, 7 * episode // 2), {}
    for number, action in enumerate(actions[: moments[-1] + 1]):
        if number in moments:
            states[number] = env.state()
        env.step(action)
    straight = _open(simulator, TASKS[task], num_envs)
    straight.reset(seed=5)
    told = _told(straight, actions)
    assert len(states) == len(moments)
    for number, state in states.items():
        again = _open(simulator, TASKS[task], num_envs)
        again.restore(state)
        last = again.state()
        # What an arm was told before its last reset is told no more.
        assert all(np.array_equal(last[name], state[name]) for name in state if name != "simulation.targets")
        assert _is_same(told[number:], _told(again, actions[number:]))
        assert again.environment_steps == straight.environment_steps
        again.close()
    for opened in (env, straight):
        opened.close()


@pytest.mark.parametrize("simulator", REGISTRY.names("simulators"))
def test_the_ground_was_touched_in_these_episodes(installed, simulator):
    """The test above says something about contact too."""
    env = _open(simulator, SHORT_TASK, 3)
    env.reset(seed=5)
    assert any(env.step(action)[2].any() for action in _actions(env, 80))
    env.close()


@pytest.mark.parametrize("reward", ["arp", "aarp", "scaled", "potential", "sparse"])
def test_what_a_reward_remembers_is_kept(reward):
    """Whatever the form of its carry."""
    env, again = (_open("kinematic", SHORT_TASK, 3, reward) for _ in range(2))
    env.reset(seed=5)
    actions = _actions(env, 40)
    _told(env, actions[:15])
    again.restore(env.state())
    assert _is_same(_told(env, actions[15:]), _told(again, actions[15:]))


def test_log_is_no_longer_than_the_episodes_under_way():
    """What came before the last resets is forgotten."""
    env = _open("kinematic", SHORT_TASK, 3)
    env.reset(seed=5)
    for action in _actions(env, 200):
        env.step(action)
        assert len(env.state()["simulation.targets"]) <= SHORT_TASK["horizon"]


def test_state_of_an_env_that_keeps_no_log_is_refused():
    """With what to do."""
    env = ReachVectorEnv(IdealSimulator(), ROBOT, ReachTask(), NegativeDistance())
    env.reset(seed=0)
    with refused("open it with resumable=True"):
        env.state()


class Drifting(IdealSimulation):
    """Each of these moves a little differently."""

    made = 0

    def __init__(self, *given: Any) -> None:
        super().__init__(*given)
        type(self).made += 1
        self.error = 1e-9 * self.made

    def drive(self, qpos, duration):
        """Not quite there."""
        return super().drive(qpos + self.error, duration)


class DriftingSimulator(IdealSimulator):
    """See `Drifting`."""

    def open(self, robot, num_envs, control_period):
        return Drifting(robot, num_envs)


def test_simulator_that_does_something_else_is_noticed():
    """The env is not where it stood: whoever restores it hears that, and what differs."""
    env, again = (
        ReachVectorEnv(DriftingSimulator(), ROBOT, ReachTask(), NegativeDistance(), 2, resumable=True) for _ in range(2)
    )
    env.reset(seed=0)
    env.step(np.ones((2, 6), np.float32))
    with pytest.raises(SchemaError, match="the simulator does not repeat itself: qpos differs"):
        again.restore(env.state())

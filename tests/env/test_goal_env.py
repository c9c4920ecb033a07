"""The env with its goal apart: recorded steps are paid again for another goal."""

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env
from numpy.random import default_rng
from numpy.testing import assert_allclose, assert_array_equal
from stable_baselines3 import SAC, HerReplayBuffer
from stable_baselines3.common import env_checker

from harness.env.goal_env import NEEDED, ReachGoalEnv, forgets_the_way
from harness.env.vector_env import ReachEnv
from harness.task import ReachTask, Targets
from tests.refusals import refused

PAYABLE = ["sparse", "potential", "adaptive", "scaled:reward=dense"]
WITH_MEMORY = ["baseline", "baseline-eq21", "arp", "aarp", "scaled:reward=arp", "shifted"]
GIVEN = {"simulator": "kinematic", "task": "fd100-reach:horizon=12,epsilon=0.03"}
TOLD = ("distance", "reward_shaped", "is_success", "task")


def _steps(env, count, seed=0):
    rng = default_rng(seed)
    env.reset(seed=seed)
    taken = []
    for _ in range(count):
        taken.append(env.step(rng.uniform(-1.0, 1.0, 6).astype(np.float32)))
        if taken[-1][2] or taken[-1][3]:
            env.reset()
    return taken


@pytest.fixture(params=PAYABLE)
def label(request):
    """Every reward that can be paid again."""
    return request.param


@pytest.fixture
def env(label):
    """One arm without an engine."""
    env = ReachGoalEnv(**GIVEN, reward=label)
    yield env
    env.close()


def test_checkers_find_no_fault(env):
    """Gymnasium's and stable-baselines3's, without a warning; the latter pays steps again, one and several."""
    check_env(env, skip_render_check=True)
    env_checker.check_env(env, warn=True, skip_render_check=True)


def test_it_pays_what_reach_pays(env, label):
    """With the same seed and actions: rewards, ends, and what is known of each step."""
    one, other = _steps(env, 30), _steps(ReachEnv(**GIVEN, reward=label), 30)
    assert_allclose([step[1] for step in one], [step[1] for step in other], rtol=0, atol=1e-12)
    assert [step[2:4] for step in one] == [step[2:4] for step in other]
    for goal_step, step in zip(one, other, strict=True):
        assert [goal_step[4][name] for name in TOLD] == [step[4][name] for name in TOLD]
        assert goal_step[4].keys() - step[4].keys() == set(NEEDED)


def test_it_pays_what_would_have_been_paid(env, label, monkeypatch):
    """Steps paid again for another goal, all at once, have the rewards of the same motion with that goal set."""
    taken = _steps(env, 12)
    goal = taken[7][0]["achieved_goal"] + [0.02, 0.0, 0.0]
    monkeypatch.setattr(
        ReachTask, "draw_targets", lambda *_: Targets(np.tile(goal, (1000, 1)), np.zeros(1000, dtype=bool))
    )
    meant = _steps(ReachEnv(**GIVEN, reward=label), 8)
    end = next(number for number, step in enumerate(meant) if step[2]) + 1
    achieved, infos = np.stack([step[0]["achieved_goal"] for step in taken[:end]]), [step[4] for step in taken[:end]]
    paid = env.compute_reward(achieved, np.tile(goal, (end, 1)), infos)
    assert end > 2
    assert_allclose(paid, [step[1] for step in meant[:end]], rtol=0, atol=1e-12)


def test_goals_are_end_effector_and_target():
    """In metres; the rest of the observation holds no target."""
    env, other = (ReachGoalEnv(**GIVEN) for _ in range(2))
    observation, _ = env.reset(seed=1)
    arm = env.vector_env.robot
    qpos = env.vector_env.episodes.qpos[0]
    assert_allclose(observation["achieved_goal"], arm.end_effector(qpos), atol=1e-9)
    assert_array_equal(observation["desired_goal"], env.vector_env.episodes.target[0])
    assert_allclose(observation["observation"][-3:], observation["achieved_goal"], atol=1e-6)
    other.reset(seed=1)
    other.vector_env.episodes.target[0] += 0.1
    assert_array_equal(other._observe()["observation"], observation["observation"])


def test_rewards_with_memory_are_refused(subtests):
    """By name, with what is allowed."""
    for reward in WITH_MEMORY:
        with (
            subtests.test(reward=reward),
            refused(rf"'{reward}' depends on .*Allowed: adaptive, dense, potential, relative, spa"),
        ):
            ReachGoalEnv(**GIVEN, reward=reward)


@pytest.mark.parametrize("task", ["unity-reach", "arp-2021", "fd100-pose", "fd100-moving"])
def test_tasks_with_several_goals_are_refused(task):
    """Their steps say nothing of which goal they were made for, or a place is not all of it."""
    with refused(rf"'{task}' sets several goals .*Allowed: .*fd100-reach, fd100-small-target"):
        ReachGoalEnv(simulator="kinematic", task=task)


def test_a_reward_that_counts_is_refused():
    """Memory in arrays counts as memory, whatever it is used for."""

    class Counting:
        def initial_carry(self, begin_distance):
            return np.zeros(len(begin_distance))

        def __call__(self, carry, sample):
            return carry + 1, -sample.distance

    assert not forgets_the_way(Counting())


def test_info_that_lacks_something_is_told():
    """As HerReplayBuffer hands over without copy_info_dict."""
    env = ReachGoalEnv(**GIVEN)
    env.reset(seed=0)
    with refused("copy_info_dict=True"):
        env.compute_reward(np.zeros((2, 3)), np.zeros((2, 3)), [{}, {}])


def _learner(task, **given):
    env = gymnasium.make("harness/ReachGoal-v0", simulator="kinematic", task=task, reward="sparse")
    return SAC(
        "MultiInputPolicy",
        env,
        replay_buffer_class=HerReplayBuffer,
        replay_buffer_kwargs={"copy_info_dict": True},
        gamma=0.95,
        learning_rate=1e-3,
        seed=0,
        **given,
    )


def test_her_runs():
    """stable-baselines3's HER pretends goals: steps that paid nothing but their price pay the target's reward."""
    model = _learner("fd100-reach:horizon=10", learning_starts=30, batch_size=64, policy_kwargs={"net_arch": [8]})
    before = [weights.clone() for weights in model.actor.parameters()]
    model.learn(40)
    assert any((old != new).any() for old, new in zip(before, model.actor.parameters(), strict=True))
    assert model.replay_buffer.rewards[:40].max() < 0.0
    assert model.replay_buffer.sample(200).rewards.max() > 0.9


@pytest.mark.slow
def test_her_learns():
    """From rewards for reaching alone, in 3,000 steps: most targets are reached, next to none before."""
    task = "fd100-reach:epsilon=0.1,horizon=50"
    given = {"learning_starts": 200, "ent_coef": 0.01, "gradient_steps": 2, "batch_size": 128}
    model = _learner(task, policy_kwargs={"net_arch": [64, 64]}, **given)
    before = _success(model, 30)
    model.learn(3000)
    assert _success(model, 30) > before + 0.3


def _success(model, episodes):
    env, reached = model.get_env().envs[0], 0
    for seed in range(episodes):
        observation, _ = env.reset(seed=10_000 + seed)
        ended = False
        while not ended:
            observation, _, terminated, truncated, info = env.step(model.predict(observation, deterministic=True)[0])
            ended = terminated or truncated
        reached += info["is_success"]
    return reached / episodes

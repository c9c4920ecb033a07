"""A reward that pays by how a step ends pays the same at every door, or the door says that it cannot know."""

from contextlib import closing
from itertools import count
from pathlib import Path

import gymnasium
import numpy as np
import pytest
from gymnasium.vector import AutoresetMode
from numpy.testing import assert_allclose, assert_array_equal

import harness
from harness import load_registry
from harness.env.goal_env import ReachGoalEnv, forgets_the_way
from harness.env.vector_env import World
from harness.experiment.arm_evaluation import play
from harness.experiment.environments.paid_again import PayAgain
from harness.log import LogFacts, in_memory, trace_of
from harness.payoff.dataset.paid_dataset import pay_dataset
from harness.payoff.dataset.rewards import given_rewards
from harness.payoff.rollout import record_rollouts, score_rollout
from harness.record import TraceWriter, read_recording, read_trace
from harness.registry import choose, read_given
from harness.reward.forms import reward_class
from harness.reward.steps import ENDS
from harness.score.places import parse_places
from harness.score.scorer import pay_log
from harness.task import ReachTask
from harness_plugins.audit import audit_rewards
from harness_plugins.audit.search.place import places_in_environment, places_on_task, world_at
from harness_plugins.kit import IdealSimulator
from tests.refusals import refused
from tests.registered import FD100, REGISTRY

SHORT = "fd100-reach:horizon=9,epsilon=0.3"
TASKS = (SHORT, "arp-2021:horizon=12", "unity-reach:horizon=20", "cluttered-reach:horizon=9")
CODE = """
def ends(step):
    return 7.0 * step.terminated + 3.0 * step.truncated
"""


def ends(step):
    """What the code says too."""
    return 7.0 * step.terminated + 3.0 * step.truncated


def nothing(step):
    """Nothing, whatever an arm does: what is paid then is the task's."""
    return 0.0 * step.distance


def due(log):
    """What each row is paid."""
    return 7.0 * log["terminated"] + 3.0 * log["truncated"]


@pytest.fixture
def registry(tmp_path):
    """With the reward as a file."""
    (tmp_path / "ends.py").write_text(CODE)
    return load_registry(given=read_given([tmp_path / "ends.py"]))


def actions_of(env):
    """Mostly down."""
    env.action_space.seed(3)
    for _ in count():
        drawn = env.action_space.sample()
        yield drawn if drawn.dtype != np.float32 else np.clip(0.4 * drawn + 0.6, -1.0, 1.0)


def train(env):
    """For a while."""
    env.reset(seed=0)
    for action, _ in zip(actions_of(env), range(120), strict=False):
        env.step(action)


def evaluate(env):
    """An episode of each."""
    actions = actions_of(env)
    play(env, lambda seen: next(actions), slice(0, 3), 3, seed=0)


def traced(task, act, mode, path, reward=None):
    """What three arms record that are paid by the reward, or by another one."""
    world = World(
        IdealSimulator(),
        FD100,
        choose(REGISTRY, "tasks", task).build(REGISTRY, "tasks"),
        reward or reward_class(ends)(),
    )
    with closing(world.open(3, autoreset_mode=mode)) as env:
        sizes = FD100.dof, env.episodes.action.shape[1]
        with TraceWriter(path, *sizes, extras=env.episodes.extras) as env.recorder:
            act(env)
    return read_trace(path).load()


DOORS = {"training": (train, AutoresetMode.SAME_STEP), "evaluation": (evaluate, AutoresetMode.DISABLED)}


@pytest.mark.parametrize("task", TASKS)
@pytest.mark.parametrize("door", DOORS)
def test_an_arm_is_paid_by_its_ends_and_so_is_its_trace(door, task, tmp_path):
    """In long decisions and with obstacles too."""
    trace = traced(task, *DOORS[door], tmp_path / "trace.parquet")
    assert_array_equal(trace["reward"], due(trace))
    assert_array_equal(pay_log(reward_class(ends)(), trace).total, due(trace))
    assert trace["reward"].any()


def test_episodes_of_these_arms_end_in_both_ways(tmp_path):
    """Else one of them would be tested nowhere."""
    found = [traced(task, *DOORS["training"], tmp_path / "trace.parquet") for task in TASKS]
    assert all(any(trace[name].any() for trace in found) for name in ENDS)


def test_a_trace_without_the_ends_is_not_paid(tmp_path):
    """It would be 0 in silence."""
    trace = traced(TASKS[0], *DOORS["training"], tmp_path / "trace.parquet")
    old = trace_of(trace.rows(name for name in trace.names if name not in ENDS).columns)
    with refused(r"The recorded run has no 'terminated'\. It has: "):
        pay_log(reward_class(ends)(), old)


def recorded(made, folder):
    """What a recorder writes of random steps of an env; and their actions."""
    rewards = {"own": "own", "live": ends} | ({"nothing": nothing} if made.metadata.get("arm") else {})
    with harness.RecordRewards(made, folder, trained_with="own", rewards=rewards) as env:
        env.action_space.seed(3)
        actions = [env.action_space.sample() for _ in range(120)]
        env.reset(seed=5)
        for action in actions:
            if any(env.step(action)[2:4]):
                env.reset()
    return read_recording(folder).load(), np.array(actions)


ENVIRONMENTS = {
    "an arm": ("harness/Reach-v0", {"simulator": "kinematic", "task": SHORT}),
    "an arm's decisions": ("harness/Reach-v0", {"simulator": "kinematic", "task": "unity-reach:horizon=20"}),
    "cart and pole": ("CartPole-v1", {"max_episode_steps": 18}),
}


@pytest.mark.parametrize("name", ENVIRONMENTS)
def test_an_environment_is_paid_by_its_ends(name, registry, tmp_path):
    """Live, its recording paid again, and by a search; what an arm's task pays beside is added everywhere."""
    made, given = ENVIRONMENTS[name]
    log, actions = recorded(gymnasium.make(made, **given), tmp_path / "one")
    beside = sum(log[name] for name in log.names if name == "reward/nothing")
    assert_allclose(log["reward/live"], due(log) + beside, rtol=1e-12)
    assert all(log[name].any() for name in ENDS)
    (paid,) = PayAgain(registry, ["ends"]).run(tmp_path / "one")
    assert_array_equal(read_recording(paid.folder).load()["reward/ends"], log["reward/live"])
    with_ = "+".join(f"{key}={value}" for key, value in given.items())
    task = choose(registry, "environments", {"name": "gymnasium", "id": made, "made_with": with_})
    (place,) = places_in_environment(registry, task, ["ends"], 0.9)
    with closing(world_at(place, registry)) as world:
        shown = world.show(5, actions)
    assert_array_equal(shown.paid, log["reward/live"][: len(shown.paid)])


def data_set(without=()):
    """Steps of an arm as a data set, whose observations are where the end effector and the target are."""
    steps = []
    with closing(gymnasium.make("harness/Reach-v0", **ENVIRONMENTS["an arm"][1])) as env:
        env.action_space.seed(3)
        for episode in range(20):
            env.reset(seed=episode)
            for step in count(1):
                action = env.action_space.sample()
                _, paid, *over, info = env.step(action)
                arm = info["arm"]
                seen, before = (np.concatenate([it.end_effector[0], it.target[0]]) for it in (arm, arm.before))
                steps.append((episode, step, before, seen, action, paid, *over))
                if any(over):
                    break
    names = ("episode", "step", "before/observation", "observation", "action", "reward/recorded", *ENDS)
    columns = {name: np.array(part) for name, part in zip(names, zip(*steps, strict=True), strict=True)}
    return in_memory(
        LogFacts(path=Path("set"), format="of a test"), {k: v for k, v in columns.items() if k not in without}
    )


PLACES = parse_places("end_effector=0:3,target=3:6")


@pytest.mark.parametrize("reward", [ends, reward_class(ends)()], ids=["a function", "an arm's"])
def test_a_data_set_is_paid_by_its_ends(reward):
    """By a function of a step of an environment, and by a reward of an arm."""
    log = data_set()
    found = pay_dataset(log, given_rewards({"ends": reward}, PLACES))
    assert found.failed == {}
    assert_array_equal(found.paid["ends"], due(log))
    assert all(log[name].any() for name in ENDS)


@pytest.mark.parametrize("reward", [ends, reward_class(ends)()], ids=["a function", "an arm's"])
def test_a_data_set_without_the_ends_is_not_paid(reward):
    """It says what a step has instead."""
    found = pay_dataset(data_set(without=ENDS), given_rewards({"ends": reward}, PLACES))
    assert found.paid == {}
    assert "has no 'terminated'. It has: " in found.failed["ends"]


def test_a_step_that_nobody_took_has_no_end():
    """Rewards that read it are compared by the steps that were taken alone, and the audit says why."""
    env = gymnasium.make("CartPole-v1", max_episode_steps=18)
    found = audit_rewards(env, {"constant": lambda step: 1.0, "ends": ends}, gamma=0.9, episodes=2)
    assert "it reads terminated, which only a step that was taken has" in str(found.to_json())


def test_a_step_is_not_paid_for_another_goal():
    """Whether that would have ended the episode, nobody asks: such a reward is none of those that are allowed."""
    assert not forgets_the_way(reward_class(ends)())
    with refused("depends on more than the distances of a step, such as how it ended"):
        ReachGoalEnv(reward="arp")


def test_a_search_of_an_arm_pays_by_its_ends(registry):
    """Beside the events."""
    (place,) = places_on_task(registry, [choose(registry, "rewards", "ends")], TASKS[0], None, None, 0.95)
    with closing(world_at(place, registry)) as world:
        found = world.at_random(range(40))
    assert {it.ended for it in found} == {*ENDS}
    for shown in found:
        assert_array_equal(np.trim_zeros(shown.terms["reward"]), [7.0 if shown.ended == "terminated" else 3.0])
        assert shown.terms["reward"][-1]


def test_rollouts_of_scripts_are_paid_by_their_ends():
    """In each script those that reach the target are terminated, and so are those that touch the ground."""
    rollouts = record_rollouts(IdealSimulator(), FD100, ReachTask(horizon=30), 6)
    for rollout in rollouts:
        values = score_rollout(reward_class(ends)(), rollout).values
        length = rollout.steps.astype(int)
        last = np.where(rollout.reached | (length < 30), 7.0, 3.0)
        assert_array_equal(values[length - 1, np.arange(6)], last)
        assert_array_equal(values.sum(axis=0), last)
    assert {it.steps.max() for it in rollouts} > {30.0}

"""Evaluation: fixed starts and targets, one episode each, the same whatever is evaluated."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal, assert_equal

from harness import load_robot
from harness.env.vector_env import build_world
from harness.executor import Cell
from harness.experiment.arm_evaluation import act_of, evaluate, record_evaluation
from harness.policy import Uniform
from harness.record import read_trace
from harness.registry import choose
from harness.task import ReachTask
from harness_plugins.kit import IdealSimulator
from tests.heavy_arms import Heavy
from tests.registered import FD100 as ROBOT, REGISTRY

CELL = Cell(
    simulator=choose(REGISTRY, "simulators", "mujoco"),
    robot="fd100",
    task=choose(REGISTRY, "tasks", "fd100-reach:horizon=6,epsilon=0.2"),
    algorithm=choose(REGISTRY, "algorithms", "sac"),
    reward=choose(REGISTRY, "rewards", "baseline"),
    seed=0,
    steps=10,
    evaluation_episodes=8,
)

FLOOR = Uniform((-1.0,) * 6, (1.0,) * 6)


def stand(observations):
    """A policy that does nothing."""
    return np.zeros((len(observations), 6), np.float32)


def record(folder, act=stand, **other):
    """The trace of an evaluation of the cell, some of it said otherwise."""
    path = folder / "evaluation.parquet"
    cell = replace(CELL, **other)
    evaluate(build_world(cell, load_robot(cell.robot), REGISTRY), lambda: act, cell.evaluation_episodes, path)
    return read_trace(path)


def starts_of(trace):
    """Joint angles and targets of the start rows."""
    starts = trace["step"] == 0
    targets = [trace[f"target_{axis}"][starts] for axis in "xyz"]
    return np.column_stack([trace["qpos"][starts], *targets])


def test_deterministic_policies_draw_nothing():
    """They act as they do without a generator."""
    seen = np.ones((3, 4), np.float32)
    assert_array_equal(act_of(FLOOR, "deterministic")(seen), FLOOR.act(seen))


def test_stochastic_policies_draw_the_same_every_time():
    """Each evaluation begins anew; within it, draws differ."""
    seen = np.ones((3, 4), np.float32)
    one, other = (act_of(FLOOR, "stochastic") for _ in range(2))
    first = one(seen)
    assert_array_equal(first, other(seen))
    assert not np.array_equal(first, one(seen))


def test_draws_are_not_those_of_random_actions():
    """Or the floor and a policy would share their noise."""
    seen = np.ones((3, 4), np.float32)
    assert not np.array_equal(act_of(FLOOR, "stochastic")(seen), act_of(FLOOR, "random")(seen))


def approach(observations):
    """A policy that goes to the target, in every second env."""
    qpos = ROBOT.lower + (observations[:, :6] + 1.0) / 2.0 * (ROBOT.upper - ROBOT.lower)
    actions = 5.0 * (observations[:, 24:27][:, None] @ ROBOT.jacobian(qpos))[:, 0]
    return (actions * (np.arange(len(actions)) % 2)[:, None]).astype(np.float32)


def test_episode_ends_with_its_last_row(tmp_path):
    """After an episode's end its env leaves no row, also when others go on."""
    trace = record(tmp_path, approach, task=choose(REGISTRY, "tasks", "fd100-reach:horizon=40"))
    lengths = {int(trace["env"][row]): int(trace["step"][row]) for row in trace.last_rows}
    assert min(lengths[env] for env in (0, 2, 4, 6)) == 40
    assert max(lengths[env] for env in (1, 3, 5, 7)) < 40
    assert lengths == {env: trace["step"][trace["env"] == env].max() for env in range(8)}


def test_starts_are_the_same_under_every_reward(tmp_path):
    """Where the episodes start, and what their targets are."""
    arp = choose(REGISTRY, "rewards", "arp:k2=3")
    assert_array_equal(starts_of(record(tmp_path)), starts_of(record(tmp_path, reward=arp)))


def test_more_episodes_begin_with_the_same_ones(tmp_path):
    """The first episodes of a larger evaluation are those of a smaller one."""
    few, many = (starts_of(record(tmp_path, evaluation_episodes=count)) for count in (3, 8))
    assert_array_equal(few, many[:3])


def test_policy_is_asked_with_the_observations(tmp_path):
    """What acts is handed float32 observations of all envs, and its actions are recorded."""
    shapes = set()

    def act(observations):
        shapes.add((observations.shape, str(observations.dtype)))
        return np.full((len(observations), 6), 0.5, np.float32)

    trace = record(tmp_path, act)
    assert shapes == {((8, 28), "float32")}
    assert (trace["action"][trace["step"] > 0] == 0.5).all()


def test_random_actions_fill_the_box():
    """The floor acts uniformly in [-1, 1], whatever is observed, and goes on drawing."""
    act = act_of(FLOOR, "random")
    actions = np.concatenate([act(np.zeros((50, 28), np.float32)) for _ in range(40)])
    assert actions.shape == (2000, 6)
    assert actions.dtype == np.float32
    assert np.abs(actions).max() <= 1.0
    assert_allclose(actions.mean(axis=0), 0.0, atol=0.06)
    assert_allclose(actions.std(axis=0), 1.0 / np.sqrt(3.0), atol=0.03)


@pytest.mark.parametrize("acted", ["random", "stochastic"])
def test_batches_leave_the_same_rows(tmp_path, acted):
    """In the same order, under the same numbers, with the same draws; and the work of the same episodes."""
    paths, world = [tmp_path / "one.parquet", tmp_path / "other.parquet"], build_world(CELL, ROBOT, REGISTRY)
    for path, simulator in zip(paths, (IdealSimulator(), Heavy()), strict=True):
        there = replace(world, simulator=simulator, task=ReachTask(horizon=40, epsilon=0.35))
        record_evaluation(there, FLOOR, acted, 8, path)
    one, other = (read_trace(path).load() for path in paths)
    assert len({len(rows) for rows in one.episodes}) > 1
    assert one.facts.episodes == other.facts.episodes
    assert_equal(*({name: of[name] for name in of.columns} for of in (one, other)))


def test_raising_policy_leaves_a_readable_trace(tmp_path):
    """An error of the policy passes through, and what was recorded before it can be read."""

    def act(observations):
        raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        record(tmp_path, act)
    assert len(read_trace(tmp_path / "evaluation.parquet")) == 0

"""Steps that the arm's own kinematics take to the target."""

from dataclasses import replace

import pytest

from harness import load_robot
from harness.env.arm_observation import kinematics_policy
from harness.env.vector_env import build_world
from harness.errors import SimulationDiverged
from harness.experiment import arm_evaluation as module
from harness.experiment.arm_evaluation import EVALUATION_SEED, evaluate, ik_steps
from harness.record import read_trace
from harness.registry import choose
from harness.task import ReachTask


def _world(make_cell, registry, task, robot="fd100", **fields):
    chosen = {kind: choose(registry, f"{kind}s", name) for kind, name in fields.items()}
    cell = make_cell(task=choose(registry, "tasks", task), robot=robot, **chosen)
    return build_world(cell, load_robot(robot, registry), registry)


@pytest.mark.parametrize(
    ("simulator", "task"),
    [
        ("ideal", "fd100-reach"),
        ("kinematic", "fd100-reach:horizon=3"),
        ("kinematic", "fd100-reach:action=set-joints"),
    ],
)
def test_steps_are_those_of_the_policy_in_an_evaluation(make_cell, toys, tmp_path, simulator, task):
    """Env by env, in the same simulator, from the same starts; None where the horizon comes first."""
    world = _world(make_cell, toys, task, simulator=simulator)
    evaluate(world, lambda: kinematics_policy(world.task, world.robot).act, 20, tmp_path / "ik.parquet")
    trace = read_trace(tmp_path / "ik.parquet")
    expected = [int(trace["step"][rows[-1]]) if trace["reached"][rows[-1]] else None for rows in trace.episodes]
    assert list(ik_steps(world, 20, EVALUATION_SEED)) == expected
    assert set(expected) != {None}


def test_target_out_of_time_is_not_reached(make_cell, toys):
    """One step is not enough for all, and for some it is."""
    assert set(ik_steps(_world(make_cell, toys, "fd100-reach:horizon=1"), 50, EVALUATION_SEED)) == {1, None}


@pytest.mark.parametrize(("task", "robot"), [("fd100-reach:action=movel", "fd100"), ("arp-2021", "unity-arm")])
def test_none_where_kinematics_cannot_act(make_cell, toys, task, robot):
    """In another action mode, and with another observation."""
    assert ik_steps(_world(make_cell, toys, task, robot), 3, EVALUATION_SEED) is None


def test_one_episode_tells_all_where_nothing_varies(make_cell, toys, monkeypatch):
    """All would be alike."""
    monkeypatch.setattr(module, "varies", lambda task: False)
    world = _world(make_cell, toys, "fd100-reach")
    assert ik_steps(world, 5, EVALUATION_SEED) == ik_steps(world, 1, EVALUATION_SEED) * 5


def test_simulation_that_diverges_tells_nothing(make_cell, toys, monkeypatch):
    """What steps are held against decides nothing: the cell goes on."""

    def diverge(*_):
        raise SimulationDiverged("the end effector is nowhere")

    monkeypatch.setattr(module, "_play", diverge)
    seed_of_no_other_test = EVALUATION_SEED + 1
    assert ik_steps(_world(make_cell, toys, "fd100-reach"), 5, seed_of_no_other_test) is None


def test_a_process_asks_once(make_cell, toys, monkeypatch):
    """It does several cells of one simulator, task and robot; another seed is another question."""
    asked = []

    def play(_, episodes, seed):
        asked.append(seed)
        return (1,) * episodes

    monkeypatch.setattr(module, "_play", play)
    for seed in (1001, 1001, 1002):
        ik_steps(_world(make_cell, toys, "fd100-reach"), 2, seed)
    assert asked == [1001, 1002]


class GoesOn(ReachTask):
    """Sets the next target, and decides every fifth step."""

    ends_at_target, decision_period = False, 5


def test_first_target_counts_where_episodes_go_on(make_cell, toys, tmp_path):
    """An episode may reach another one in the same decision."""
    world = replace(_world(make_cell, toys, "fd100-reach"), task=GoesOn(horizon=60, epsilon=0.2))
    evaluate(world, lambda: kinematics_policy(world.task, world.robot).act, 9, tmp_path / "ik.parquet")
    trace = read_trace(tmp_path / "ik.parquet")
    reached = [trace["step"][rows][trace["reached"][rows]].astype(int).tolist() for rows in trace.episodes]
    assert any((a - 1) // 5 == (b - 1) // 5 for a, b, *_ in reached)
    assert list(ik_steps(world, 9, EVALUATION_SEED)) == [steps[0] for steps in reached]

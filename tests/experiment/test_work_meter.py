"""Work of the episodes of an evaluation, from the rows that it leaves."""

from numpy.testing import assert_allclose

from harness.env.vector_env import build_world
from harness.experiment.arm_evaluation import act_of, evaluate
from harness.log import episode_facts
from harness.policy import Uniform
from harness.record import read_trace
from harness.registry import choose
from harness.robot.energy import least_work, read_bodies
from tests.registered import FD100

FLOOR = Uniform((-1.0,) * 6, (1.0,) * 6)


def _world(make_cell, registry, task):
    simulator = choose(registry, "simulators", "kinematic")
    cell = make_cell(task=choose(registry, "tasks", task), simulator=simulator)
    return build_world(cell, FD100, registry)


def _left(world, folder, episodes):
    evaluate(world, lambda: act_of(FLOOR, "random"), episodes, folder / "evaluation.parquet")
    return read_trace(folder / "evaluation.parquet")


def test_work_is_that_of_the_recorded_rows(make_cell, toys, tmp_path):
    """Env by env: what follows the first episode of an env, and other envs, has no part in it."""
    world = _world(make_cell, toys, "fd100-reach:horizon=30,epsilon=0.3")
    trace = _left(world, tmp_path, 6)
    bodies = read_bodies(world.robot)
    expected = [least_work(world.robot.chain, bodies, trace["qpos"][rows], 0.1) for rows in trace.episodes]
    assert len({len(rows) for rows in trace.episodes}) > 1
    assert_allclose(episode_facts(trace).work, expected, rtol=1e-12)
    assert min(expected) > 0.0


def test_arm_that_jumps_does_no_work_that_is_known(make_cell, toys, tmp_path):
    """From pose to pose nothing is known of the way."""
    assert (
        episode_facts(_left(_world(make_cell, toys, "fd100-reach:action=set-joints,horizon=3"), tmp_path, 2)).work
        is None
    )


def test_arm_without_mass_does_no_work_that_is_known(make_cell, toys, tmp_path, monkeypatch):
    """None is made up."""
    monkeypatch.setattr("harness.experiment.arm_evaluation.read_bodies", lambda robot: None)
    assert episode_facts(_left(_world(make_cell, toys, "fd100-reach:horizon=3"), tmp_path, 2)).work is None

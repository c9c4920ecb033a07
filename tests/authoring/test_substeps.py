"""Physics steps per duration, and movel in every simulator that there is."""

import numpy as np
import pytest
from numpy.linalg import norm

import harness
from harness import load_registry
from harness.registry.choice import choose
from harness.simulator import Substeps
from harness.task import Setting, build_motion
from tests.refusals import refused

REGISTRY = load_registry()
SIMULATORS = ("kinematic", "mujoco", "pybullet", "dm_control", "drake", "physx", "mjx")
PERIOD = 0.1


@pytest.mark.parametrize(("count", "parts", "steps"), [(20, 1, 20), (20, 4, 5), (20, 20, 1), (7, 7, 1), (33, 3, 11)])
def test_a_part_has_its_share_of_the_steps(count, parts, steps):
    """As many as the control period's, divided by the parts."""
    assert Substeps(count, PERIOD).within(PERIOD / parts) == steps


@pytest.mark.parametrize(("count", "parts"), [(20, 3), (20, 40), (7, 2), (1, 4)])
def test_parts_that_do_not_divide_are_a_usage_error(count, parts):
    """It says the substeps and the parts."""
    with refused(rf"substeps={count} .* {parts} parts"):
        Substeps(count, PERIOD).within(PERIOD / parts)


@pytest.mark.parametrize("simulator", SIMULATORS[1:])
def test_every_engine_says_that_it_cannot_divide(installed, simulator):
    """Through the env: the first step that would need a part of a physics step is refused."""
    env = harness.make_env(f"{simulator}:substeps=20", "fd100-reach:action=movel:parts=3")
    env.reset(seed=0)
    try:
        with refused(r"substeps=20 .* 3 parts"):
            env.step(env.action_space.sample())
    finally:
        env.close()


@pytest.mark.parametrize("frame", ["wcs", "tcs"])
@pytest.mark.parametrize("simulator", SIMULATORS)
def test_every_engine_follows_the_line(installed, simulator, frame):
    """At the end of every part the driven end effector is within 4 mm of the line that movel commands."""
    robot = harness.load_robot("fd100")
    motion = build_motion(f"movel:frame={frame}", Setting(robot, PERIOD, 0.8, 0.6))
    world = np.array([[0.0, 0.8, 0.6], [-0.6, 0.8, 0.0], [0.0, -1.0, 0.0]])
    qpos, qvel = np.tile(robot.home, (3, 1)), np.zeros((3, 6))
    start = robot.end_effector(qpos)
    simulation = choose(REGISTRY, "simulators", simulator).build(REGISTRY, "simulators").open(robot, 3, PERIOD)
    try:
        simulation.reset(qpos, np.ones(3, bool))
        for _ in range(8):
            axes = motion.axes.to_world(qpos, np.tile(np.eye(3), (3, 1, 1)))
            move = motion.advance(qpos, qvel, np.vecdot(axes, world[:, None]))
            assert not move.held.any()
            for waypoint in move.waypoints:
                way = simulation.drive(waypoint, PERIOD / 4).end_effector - start
                assert norm(way - np.vecdot(way, world)[:, None] * world, axis=1).max() < 4e-3
            qpos, qvel = move.waypoints[-1], move.qvel
    finally:
        simulation.close()
    assert norm(way, axis=1).min() > 0.25

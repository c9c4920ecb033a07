"""dm_control: as `mujoco` to 1e-9, each arm an environment of its own, divergence."""

import numpy as np
import pytest
from dm_control.rl import control
from numpy.testing import assert_allclose, assert_array_equal

from harness.errors import SimulationDiverged
from harness.simulator import State
from tests.plugins.simulators.conftest import (
    PERIOD,
    ROBOT,
    assert_same,
    home,
    open_simulator,
    press,
    random_poses,
    wander,
)

SETTINGS = ({}, {"substeps": 7, "bandwidth": 60.0})


@pytest.fixture(scope="module", params=SETTINGS, ids=str)
def beside_mujoco(request):
    """The states of 300 periods, fields (300, 3, ...), of dm_control and of mujoco with equal settings."""
    runs = [wander(open_simulator(name, 3, **request.param), 3, 300)[0] for name in ("dm_control", "mujoco")]
    return tuple(State._make(np.stack(field) for field in zip(*run, strict=True)) for run in runs)


@pytest.mark.parametrize("field", ["qpos", "qvel", "end_effector"])
def test_moves_as_mujoco(beside_mujoco, field):
    """With equal settings 300 periods of random moves, ground contacts included, agree to 1e-9."""
    ours, theirs = (getattr(state, field) for state in beside_mujoco)
    assert np.ptp(ours, axis=0).min() > 0.1
    assert_allclose(ours, theirs, rtol=0.0, atol=1e-9)


def test_touches_the_ground_when_mujoco_does(beside_mujoco):
    """In the same periods, of which there are some."""
    ours, theirs = (state.ground_contact for state in beside_mujoco)
    assert 5 < ours.sum() < 300
    assert_array_equal(ours, theirs)


def test_pressed_on_arm_is_held_up_as_in_mujoco():
    """An arm that is driven into the ground and pushes against it is where that of mujoco is."""
    runs = [press(open_simulator(name, 1), 30) for name in ("dm_control", "mujoco")]
    for ours, theirs in zip(*runs, strict=True):
        for array, other in zip(ours, theirs, strict=True):
            assert_allclose(array, other, rtol=0.0, atol=1e-9)
    assert sum(state.ground_contact[0] for state in runs[0]) > 5


def test_placed_arms_are_as_those_of_mujoco():
    """Poses anywhere in the joint ranges give the same end effectors and the same contacts."""
    ours, theirs = (open_simulator(name, 200).place(random_poses(200)) for name in ("dm_control", "mujoco"))
    assert 20 < ours.ground_contact.sum() < 180
    assert_array_equal(ours.ground_contact, theirs.ground_contact)
    assert_allclose(ours.end_effector, theirs.end_effector, rtol=0.0, atol=1e-9)


def test_every_arm_has_a_physics_of_its_own(open_arms):
    """Each env is a `control.Environment` with its own data; the model is shared."""
    arms = open_arms(3).arms
    assert all(isinstance(arm, control.Environment) for arm in arms)
    assert len({id(arm.physics.data.ptr) for arm in arms}) == 3
    assert len({id(arm.physics.model.ptr) for arm in arms}) == 1


def test_a_period_is_one_step_of_the_environment(open_arms):
    """Driving steps dm_control's physics by the control period, in as many substeps as asked for."""
    simulation = open_arms(1, substeps=5)
    simulation.drive(home(1), PERIOD)
    (arm,) = simulation.arms
    assert arm.control_timestep() == pytest.approx(PERIOD)
    assert (arm.physics.time(), arm.physics.timestep()) == pytest.approx((PERIOD, PERIOD / 5))


def test_actions_are_joint_positions_within_their_ranges(open_arms):
    """dm_control's own description of an arm's actions has the robot's ranges."""
    spec = open_arms(1).arms[0].action_spec()
    assert spec.shape == (ROBOT.dof,)
    assert_array_equal([spec.minimum, spec.maximum], [ROBOT.lower, ROBOT.upper])


def test_arm_can_be_used_as_dm_control_uses_it(open_arms):
    """Reset and stepped as any environment of dm_control, an arm goes where the action says and observes it."""
    (arm,) = open_arms(1).arms
    assert arm.reset().first()
    goal = ROBOT.home + 0.02
    step = arm.step(goal)
    assert step.mid()
    assert_allclose(step.observation["qpos"], goal, atol=1e-2)
    assert {name: spec.shape for name, spec in arm.observation_spec().items()} == {
        "qpos": (6,), "qvel": (6,), "end_effector": (3,), "touch": (1,),
    }  # fmt: skip


def test_joints_have_their_names(open_arms):
    """Where each joint is told another angle, each has its own by dm_control's names."""
    pose = np.radians([-50.0, -30.0, 20.0, 70.0, 110.0, 200.0])
    simulation = open_arms(1)
    simulation.place(pose[None])
    assert_array_equal(simulation.arms[0].physics.named.data.qpos[list(ROBOT.joint_names)], pose)


@pytest.mark.parametrize("target", [np.nan, np.inf])
def test_invalid_state_is_a_diverged_simulation(target, open_arms):
    """What dm_control calls a PhysicsError ends the cell as SimulationDiverged, which names the env and the cause."""
    simulation = open_arms(2)
    targets = home(2)
    targets[1, 2] = target
    with pytest.raises(SimulationDiverged, match=r"env 1: Physics state is invalid.*mjWARN_BADCTRL") as caught:
        simulation.drive(targets, PERIOD)
    assert isinstance(caught.value.__cause__, control.PhysicsError)


def test_state_that_runs_away_is_a_diverged_simulation(open_arms):
    """An arm whose speed leaves what can be computed is stopped at the step in which it does."""
    simulation = open_arms(1)
    simulation.arms[0].physics.data.qvel[0] = 1e12
    with pytest.raises(SimulationDiverged, match="env 0: Physics state is invalid"):
        simulation.drive(home(1), PERIOD)


def test_diverged_arm_can_be_reset(open_arms):
    """After a reset an arm that diverged moves as a new one."""
    simulation = open_arms(1)
    with pytest.raises(SimulationDiverged):
        simulation.drive(np.full((1, ROBOT.dof), np.nan), PERIOD)
    simulation.reset(home(1), np.ones(1, bool))
    assert_same(wander(simulation, 1, 20)[0], wander(open_arms(1), 1, 20)[0])


def test_frame_is_that_of_mujoco(egl):
    """The same camera looks at the same arm."""
    target = np.array([0.6, 0.3, 0.6])
    assert_array_equal(*[open_simulator(name, 1).render(0, target, 320, 240) for name in ("dm_control", "mujoco")])

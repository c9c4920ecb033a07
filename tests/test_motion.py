"""MoveJ: whatever the actions, the joints stay within their limits, and can stop."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import harness
from harness.motion import MoveJ

ROBOT = harness.load_robot("fd100")
FD100 = MoveJ.within_limits(ROBOT, speed=0.8, acceleration=0.6, period=0.1)

ACTIONS = st.lists(st.sampled_from([-2.0, -1.0, -0.4, 0.0, 0.3, 1.0, 2.0]), min_size=1, max_size=40)


@st.composite
def motions(draw: st.DrawFn) -> MoveJ:
    """A MoveJ of one joint with any range and limits, also where it needs many periods to brake."""
    lower = draw(st.floats(-3.0, 3.0))
    width = draw(st.floats(0.01, 5.0))
    max_speed = draw(st.floats(0.5, 10.0))
    max_change = max_speed * draw(st.floats(0.05, 2.0))
    period = draw(st.floats(0.05, 0.2))
    return MoveJ(np.array([lower]), np.array([lower + width]), np.array([max_speed]), np.array([max_change]), period)


def follow(motion: MoveJ, start: float, actions: list[float]) -> tuple[np.ndarray, np.ndarray]:
    """Positions and speeds, (periods + 1, dof), of actions for all joints from a place in the range, at rest."""
    qpos = (motion.lower + start * (motion.upper - motion.lower))[None]
    qvel = np.zeros_like(qpos)
    path = [(qpos, qvel)]
    for action in actions:
        path.append(motion.advance(*path[-1], np.full_like(qpos, action)))
    positions, speeds = zip(*path, strict=True)
    return np.concatenate(positions), np.concatenate(speeds)


@given(motions(), st.floats(0.0, 1.0), ACTIONS)
def test_speed_stays_within_its_limit(motion: MoveJ, start: float, actions: list[float]):
    """No joint is ever faster than its maximum speed."""
    _, speeds = follow(motion, start, actions)
    assert (np.abs(speeds) <= motion.max_speed * (1.0 + 1e-9)).all()


@given(motions(), st.floats(0.0, 1.0), ACTIONS)
def test_speed_changes_within_its_limit(motion: MoveJ, start: float, actions: list[float]):
    """From one period to the next no speed changes by more than the acceleration allows."""
    _, speeds = follow(motion, start, actions)
    assert (np.abs(np.diff(speeds, axis=0)) <= motion.max_change * (1.0 + 1e-9)).all()


@given(motions(), st.floats(0.0, 1.0), ACTIONS)
def test_joint_never_leaves_its_range(motion: MoveJ, start: float, actions: list[float]):
    """No joint is ever beyond an end of its range."""
    positions, _ = follow(motion, start, actions)
    assert (positions >= motion.lower).all()
    assert (positions <= motion.upper).all()


@given(motions(), st.floats(0.0, 1.0), ACTIONS)
def test_speed_leads_to_the_target(motion: MoveJ, start: float, actions: list[float]):
    """The joint moves through each period at the speed that is told: the range's end never cuts a motion short."""
    positions, speeds = follow(motion, start, actions)
    np.testing.assert_allclose(np.diff(positions, axis=0), speeds[1:] * motion.period, rtol=0.0, atol=1e-9)


@given(motions(), st.floats(0.0, 1.0), ACTIONS)
def test_joint_can_always_stop(motion: MoveJ, start: float, actions: list[float]):
    """Told to stop, a joint stands still after as many periods as its speed takes, wherever it is."""
    periods = int(np.ceil(motion.max_speed[0] / motion.max_change[0])) + 1
    _, speeds = follow(motion, start, actions + [0.0] * periods)
    assert abs(speeds[-1, 0]) < 1e-9


@given(motions(), st.sampled_from([-1.0, 1.0]))
def test_both_ends_can_be_reached(motion: MoveJ, direction: float):
    """Driven on in one direction, a joint comes to rest at the end of its range: the brake is not too careful."""
    periods = int(np.ceil((motion.upper - motion.lower)[0] / (motion.max_speed[0] * motion.period)))
    braking = int(np.ceil(motion.max_speed[0] / motion.max_change[0]))
    positions, _ = follow(motion, 0.5, [direction] * (4 * (periods + braking) + 60))
    end = motion.upper if direction > 0.0 else motion.lower
    np.testing.assert_allclose(positions[-1], end, atol=1e-6)


@given(st.integers(0, 2**32 - 1))
def test_batch_is_its_envs_one_by_one(seed: int):
    """Each arm of a batch gets, bit for bit, what it gets alone, also where only its neighbours have to brake."""
    rng = np.random.default_rng(seed)
    share = rng.choice([0.0, 0.001, 0.5, 0.999, 1.0], (4, 1)) * np.ones(FD100.lower.shape)
    qpos = FD100.lower + share * (FD100.upper - FD100.lower)
    qvel = rng.uniform(-1.0, 1.0, qpos.shape) * FD100.max_change * (np.abs(share - 0.5) < 0.4)
    action = rng.uniform(-1.0, 1.0, qpos.shape)
    positions, speeds = FD100.advance(qpos, qvel, action)
    for env in range(len(qpos)):
        alone = FD100.advance(qpos[env : env + 1], qvel[env : env + 1], action[env : env + 1])
        np.testing.assert_array_equal(alone[0][0], positions[env])
        np.testing.assert_array_equal(alone[1][0], speeds[env])


def test_arguments_are_left_alone():
    """Positions, speeds and actions of the caller are not changed."""
    qpos, qvel, action = np.array(ROBOT.home)[None], np.zeros((1, 6)), np.full((1, 6), 3.0)
    given = qpos.copy(), qvel.copy(), action.copy()
    FD100.advance(qpos, qvel, action)
    for array, before in zip((qpos, qvel, action), given, strict=True):
        np.testing.assert_array_equal(array, before)


def test_action_beyond_the_box_is_clipped():
    """An action of 7 is one of 1."""
    qpos, qvel = ROBOT.home[None], np.zeros((1, 6))
    for beyond, full in ((7.0, 1.0), (-7.0, -1.0)):
        first, second = (FD100.advance(qpos, qvel, np.full((1, 6), action)) for action in (beyond, full))
        np.testing.assert_array_equal(first, second)


def test_robot_takes_its_shares_of_speed_and_acceleration():
    """A full action gains 60 % of the maximum acceleration per period, up to 80 % of the maximum speed."""
    _, speeds = follow(FD100, 0.5, [1.0] * 4)
    np.testing.assert_allclose(speeds[1], np.minimum(0.6 * ROBOT.max_acceleration * 0.1, FD100.max_speed))
    np.testing.assert_allclose(speeds[-1], 0.8 * ROBOT.max_speed)


@pytest.mark.parametrize("action", [0.25, -0.5])
def test_action_is_a_fraction_of_the_maximum_speed(action: float):
    """In the end a joint has the speed that is asked for."""
    _, speeds = follow(FD100, 0.5, [action] * 3)
    np.testing.assert_allclose(speeds[-1], action * FD100.max_speed)

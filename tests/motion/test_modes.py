"""Action modes by their names, and what is wrong with others."""

import numpy as np
import pytest
from numpy.random import default_rng
from numpy.testing import assert_allclose

from harness.motion.discrete import Discrete
from harness.motion.modes import MODES
from harness.registry import choose
from harness.registry.members import parameters_of
from harness.task import ReachTask, build_motion
from tests.refusals import refused
from tests.registered import REGISTRY

SIZES = {"movej": 6, "movej-absolute": 6, "movel": 3, "movea": 6, "set-joints": 6, "discrete": 6}


def test_every_mode_moves_the_fd100(fd100, setting_of, subtests):
    """By its name alone, with as many numbers in an action as it says."""
    for mode in MODES:
        with subtests.test(mode=mode):
            assert build_motion(mode, setting_of(fd100)).action_size == SIZES[mode]


@pytest.mark.parametrize("mode", [*MODES, *(f"discrete:action={mode}" for mode in MODES if mode != "discrete")])
def test_stay_moves_no_arm(arm, setting_of, course_of, poses, mode):
    """Of arms at rest, by more than rounding; none of them is held."""
    motion, qpos = build_motion(mode, setting_of(arm)), poses(arm, 30)
    course = course_of(motion, qpos, [motion.stay(qpos)])
    assert_allclose(course.qpos[-1], qpos, rtol=0.0, atol=1e-12)
    assert not course.held.any()


@pytest.mark.parametrize(
    ("mode", "actions"),
    [
        ("movej", [-1e9, -1.0, -0.1, 0.0, 0.5, 1.0]),
        ("movej-absolute", [-2.0, -1.3, -0.4, 0.1, 0.9, 1.7]),
        *((f"{name}:frame={frame},tip_speed=2", [-1e9, -1.0, 0.0, 1e-9, 0.1, 1.0])
          for name in ("movel", "movea") for frame in ("wcs", "tcs")),
    ],
)  # fmt: skip
def test_random_actions_stay_within_the_limits(arm, setting_of, course_of, require_limits, poses, mode, actions):
    """From anywhere in the ranges, singular poses and the ends of the ranges included, whatever the actions."""
    motion, rng, is_straight = build_motion(mode, setting_of(arm)), default_rng(0), ":" in mode
    start = poses(arm, 30)
    start[0], start[1], start[2] = arm.lower, arm.upper, 0.0
    drawn = rng.choice(actions, (10 if is_straight else 150, 30, motion.action_size))
    course = course_of(motion, start, np.repeat(drawn, 3 if is_straight else 1, axis=0))
    require_limits(course, setting_of(arm).limits(4 if is_straight else 1))


def test_every_parameter_is_described(subtests):
    """A user sees what each is for."""
    for mode in MODES:
        with subtests.test(mode=mode):
            assert all(parameter.description for parameter in parameters_of(MODES[mode]))


def test_every_mode_is_a_tasks(fd100, subtests):
    """The reach task can be done in it."""
    for mode in MODES:
        with subtests.test(mode=mode):
            ReachTask(action=mode).check(fd100)


@pytest.mark.parametrize(
    ("text", "parts"),
    [
        ("discrete:action=movel:frame=tcs,parts=2", 2),
        ("discrete:action=(movel:frame=tcs,parts=2)", 2),
        ("discrete:action=movel:frame=tcs", 4),
        ("discrete:action=movel", 4),
    ],
)
def test_the_mode_within_discrete_has_its_parameters(fd100, setting_of, text, parts):
    """With and without parentheses."""
    motion = build_motion(text, setting_of(fd100))
    assert isinstance(motion, Discrete)
    assert motion.inner.parts == parts


@pytest.mark.parametrize(
    ("text", "action", "epsilon"),
    [
        ("fd100-reach:action=movel:frame=tcs,epsilon=0.1", "movel:frame=tcs", 0.1),
        ("fd100-reach:action=movel:frame=tcs,parts=2,epsilon=0.1", "movel:frame=tcs,parts=2", 0.1),
        ("fd100-reach:epsilon=0.1,action=movel:frame=tcs,parts=2", "movel:frame=tcs,parts=2", 0.1),
        ("fd100-reach:action=discrete:action=movel:frame=tcs,parts=2", "discrete:action=movel:frame=tcs,parts=2", 0.05),
        ("fd100-reach:action=(movel:frame=tcs,parts=2),epsilon=0.1", "movel:frame=tcs,parts=2", 0.1),
    ],
)
def test_the_mode_within_a_task_has_its_parameters(text, action, epsilon):
    """What the task does not know belongs to its mode."""
    task = choose(REGISTRY, "tasks", text).build(REGISTRY, "tasks")
    assert (task.action, task.epsilon) == (action, epsilon)


def test_what_is_wrong_is_said_in_one_line(fd100, setting_of, subtests):
    """Each is one UsageError."""
    for text, message in [
        ("moveL", "No action mode 'moveL'.*Did you mean 'movel'"),
        ("movej:speed=1", "Action mode 'movej' has no parameter 'speed'. There is: none"),
        ("movel:fram=tcs", "has no parameter 'fram'.*Did you mean 'frame'"),
        ("movel:frame=jcs", "frame='jcs'"),
        ("movel:tip_speed=0", "tip_speed"),
        ("movel:tip_speed=nan", "tip_speed"),
        ("movel:parts=0", "parts"),
        ("movel:parts=2.5", "parts"),
        ("movea:ucs_x=1x0", "ucs_x"),
        ("movel:frame=ucs,ucs_x=1x0x0,ucs_xy=2x0x0", "one line"),
        ("movel:", "malformed"),
        ("discrete:action=discrete", "cannot stand inside itself"),
        ("discrete:action=discrete:action=movel", "cannot stand inside itself"),
        ("discrete:action=walk", "No action mode 'walk'"),
        ("discrete:action=movel,parts=2", "Action mode 'discrete' has no parameter 'parts'"),
        ("discrete:action=movel:speed=2", "Action mode 'movel' has no parameter 'speed'"),
    ]:
        with subtests.test(text=text), refused(message):
            build_motion(text, setting_of(fd100))

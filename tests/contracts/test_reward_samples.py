"""The steps that the reward checks hand to a reward are those of an arm that could be."""

import copy
from itertools import pairwise

import numpy as np
import pytest

from harness.reward.forms import reward_class
from harness.reward.steps import ARM, ARM_BEFORE
from harness_plugins.kit.reward_samples import PERIOD, edge_samples, joints_of, random_samples

EVERY = [random_samples(3), random_samples(4, num_envs=1, steps=30, joints=7), edge_samples()]
RANDOM = EVERY[:2]


@pytest.mark.parametrize("samples", EVERY)
def test_steps_have_every_field(samples):
    """With the shapes of the table; before too."""
    envs, joints = samples[0].qpos.shape
    sizes = {"num_envs": envs, "dof": joints, "action_size": joints, "3": 3}
    for step in samples:
        for field in ARM:
            shape = tuple(sizes[part] for part in field.shape.strip("()").replace(" ", "").split(",") if part)
            assert getattr(step, field.name).shape == shape
            if field.before:
                assert getattr(step.before, field.name).shape == shape


@pytest.mark.parametrize("samples", EVERY)
def test_the_target_is_as_far_as_the_distance_says(samples):
    """Before and after the step."""
    for step in samples:
        for of in (step, step.before):
            np.testing.assert_allclose(np.linalg.norm(of.target - of.end_effector, axis=1), of.distance, atol=1e-12)
        assert (step.previous_distance == step.before.distance).all()
        assert (step.delta_distance == step.distance - step.previous_best).all()


@pytest.mark.parametrize("samples", RANDOM)
def test_what_was_before_is_the_step_before(samples):
    """And the first one begins at rest."""
    for one, other in pairwise(samples):
        for name in ARM_BEFORE:
            assert (getattr(other.before, name) == getattr(one, name)).all()
    first = samples[0]
    assert not first.before.action.any()
    assert not first.before.qvel.any()
    assert (first.begin_distance == first.before.distance).all()


@pytest.mark.parametrize("samples", RANDOM)
def test_joints_move_as_fast_as_they_say(samples):
    """Their places change by speed times period."""
    for step in samples:
        np.testing.assert_allclose(step.qpos - step.before.qpos, PERIOD * step.qvel, atol=1e-12)


def test_some_steps_touch_the_ground_and_edges_have_rest_and_motion():
    """Corners that a reward may divide by."""
    assert any(step.ground.any() for step in random_samples(0, steps=100))
    still, moving = edge_samples()
    assert not still.qvel.any()
    assert not still.action.any()
    assert moving.qvel.all()
    assert moving.ground.all()


def test_steps_own_their_arrays():
    """Who writes into one changes no other, and a copy has all fields."""
    first, second, *_ = random_samples(0)
    second.before.action[...] = 9.0
    assert not (first.action == 9.0).any()
    assert (copy.deepcopy(second).before.action == 9.0).all()


@pytest.mark.parametrize(("joint", "joints"), [(0, 6), (5, 6), (6, 7), (7, 8), (40, 6)])
def test_the_joints_are_as_many_as_the_reward_reads(joint, joints):
    """The usual six, more where it reads more, and six for one that no arm can be meant for."""

    class Reads:
        def initial_carry(self, begin_distance):
            return ()

        def __call__(self, carry, step):
            return carry, step.qpos[:, joint]

    assert joints_of(Reads()) == joints


def test_a_function_of_seven_joints_is_for_seven():
    """As `reward_class` finds it too."""
    assert joints_of(reward_class(seventh)()) == 7


def seventh(step):
    """Reads the seventh joint."""
    return step.qpos[:, 6]

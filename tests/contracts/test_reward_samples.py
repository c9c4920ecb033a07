"""The steps that the reward checks hand to a reward are those of an arm that could be."""

import copy
from itertools import pairwise

import numpy as np
import pytest

from harness.reward.steps import ARM, ARM_BEFORE
from harness_plugins.kit.reward_samples import PERIOD, edge_samples, joints_of, random_samples

from .mutants.rewards import SOUND, pays

RANDOM = [random_samples(3), random_samples(4, num_envs=1, steps=30, joints=7)]
EVERY = [step for samples in (*RANDOM, edge_samples()) for step in samples]


def test_steps_have_every_field():
    """With the shapes of the table; before too."""
    for step in EVERY:
        envs, joints = step.qpos.shape
        sizes = {"num_envs": envs, "dof": joints, "action_size": joints, "3": 3}
        for field in ARM:
            shape = tuple(sizes[part] for part in field.shape.strip("()").replace(" ", "").split(",") if part)
            assert {getattr(of, field.name).shape for of in (step, step.before)[: 1 + field.before]} == {shape}


def test_the_target_is_as_far_as_the_distance_says():
    """Before and after the step."""
    for step in EVERY:
        for of in (step, step.before):
            np.testing.assert_allclose(np.linalg.norm(of.target - of.end_effector, axis=1), of.distance, atol=1e-12)
        assert (step.previous_distance == step.before.distance).all()
        assert (step.delta_distance == step.distance - step.previous_best).all()


@pytest.mark.parametrize("samples", RANDOM)
def test_what_was_before_is_the_step_before(samples):
    """The first one begins at rest, and joints move as fast as they say: places change by speed times period."""
    for one, other in pairwise(samples):
        assert all((getattr(other.before, name) == getattr(one, name)).all() for name in ARM_BEFORE)
    first = samples[0].before
    assert not first.action.any()
    assert not first.qvel.any()
    assert (samples[0].begin_distance == first.distance).all()
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
    """The usual six, more where it reads more, and six for one that no arm can be meant for; of functions too."""
    assert joints_of(pays(lambda step: step.qpos[:, joint])) == joints
    assert joints_of(SOUND[-1]) == 7

"""Steps of the policy beside those of the arm's own kinematics."""

import numpy as np
import pytest

from harness.record import EpisodeFacts
from harness.record.trace import with_episode_facts
from harness_plugins.kit.metrics import recorded_trace
from harness_plugins.metrics.episodes import Optimality

ENDS = ("reached", "truncated", "reached", "ground", "reached")


def told(*ik_steps):
    """One episode in each of five envs, with these steps of the kinematics; those that reach take 10, 20, 4 steps."""
    trace = recorded_trace(0, ENDS)
    trace["env"][:], trace["episode"][:] = trace["episode"].copy(), 0
    trace["step"][trace.last_rows] = [10, 9, 20, 9, 4]
    return with_episode_facts(trace, EpisodeFacts(ik_steps=ik_steps))


def test_kinematics_steps_over_the_policys():
    """Each episode by itself; one in which the policy fails counts 0."""
    assert Optimality()(told(5, 5, 5, 5, 4)) == pytest.approx((0.5 + 0.0 + 0.25 + 0.0 + 1.0) / 5)


def test_policy_that_is_faster_is_above_one():
    """Nothing is cut off."""
    assert Optimality()(told(20, None, 20, None, 4)) == pytest.approx((2.0 + 1.0 + 1.0) / 3)


def test_what_the_kinematics_do_not_reach_is_left_out():
    """Whether the policy reaches it or not."""
    assert Optimality()(told(5, None, None, 5, None)) == pytest.approx((0.5 + 0.0) / 2)


def test_envs_are_told_apart():
    """The order in which they were written changes nothing."""
    trace = told(5, 6, 7, 8, 9)
    mixed = trace.part(np.argsort(-trace["env"], kind="stable"))
    assert Optimality()(mixed) == pytest.approx(Optimality()(trace))


def test_none_where_the_kinematics_reach_nothing_or_are_not_told():
    """Nothing to hold the steps against."""
    assert Optimality()(told(*[None] * 5)) is None
    assert Optimality()(with_episode_facts(told(), EpisodeFacts())) is None

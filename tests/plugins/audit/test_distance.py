"""Distances between rewards: pseudometrics that scale, offset and shaping do not change."""

import itertools
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from numpy.random import default_rng

from harness.payoff.rollout import record_rollouts
from harness.task import ReachTask
from harness_plugins.audit.distance import FORMS, SHAPING, compare_forms, distance_between
from harness_plugins.audit.transitions.rollout_forms import forms_of_rollouts
from harness_plugins.kit import IdealSimulator
from tests.payoff.conftest import ARP, BASELINE, DENSE, REGISTRY, RELATIVE, Counting, Paying, named, potential

GAMMA = 0.95


@pytest.fixture(scope="module")
def short(robot):
    """Rollouts of short episodes: pairs of rewards are many."""
    return record_rollouts(IdealSimulator(), robot, ReachTask(horizon=30), 8)


def apart(one, other, rollouts):
    """By canonical form, how far apart; None where it is not defined."""
    forms = [forms_of_rollouts(reward, rollouts, GAMMA) for reward in (one, other)]
    return {form: distance_between(forms[0][form], forms[1][form]) for form in FORMS}


@pytest.fixture(scope="module")
def between(short):
    """All distances of two rewards in short episodes."""
    return lambda one, other=BASELINE: list(apart(one, other, short).values())


def changed(factor, offset=0.0, phi=lambda distance: 0.0 * distance):
    """The baseline times a factor, plus an offset and shaping by a potential."""

    def value(sample):
        shaping = GAMMA * phi(sample.distance) - phi(sample.previous_distance)
        return factor * BASELINE((), sample)[1] + offset + shaping

    return Paying(value)


NOTHING = [pytest.approx(0.0, abs=1e-9)] * 3


@pytest.mark.parametrize("name", REGISTRY.names("rewards"))
def test_no_distance_to_itself(between, name):
    """Every reward is at 0 from itself, exactly."""
    assert between(named(name), named(name)) == [0.0] * 3


@settings(max_examples=6)
@given(st.floats(0.01, 100.0), st.floats(-10.0, 10.0), st.floats(-5.0, 5.0), st.floats(-5.0, 5.0))
def test_scale_offset_and_shaping_do_not_count(between, factor, offset, slope, bend):
    """A positive factor, a constant per step and a potential of the distance change nothing."""
    assert between(changed(factor)) == NOTHING
    assert between(changed(1.0, offset)) == NOTHING
    assert between(changed(1.0, 0.0, lambda distance: slope * distance + bend * np.sin(3.0 * distance))) == NOTHING


def test_the_order_does_not_count(between):
    """Whatever the rewards, the distance is symmetric, in [0, 1] where there is one; of the opposite it is 1."""
    assert between(changed(-1.0)) == pytest.approx([1.0] * 3)
    rewards = [named(name) for name in REGISTRY.names("rewards")]
    for one, other in itertools.pairwise([*rewards, rewards[0]]):
        values = between(one, other)
        assert values == between(other, one)
        assert all(value is None or 0.0 <= value <= 1.0 for value in values)


def test_a_detour_is_no_shorter(between):
    """The triangle inequality. ARP differs from the baseline, and the relative gain differs more."""
    rewards = [BASELINE, ARP, RELATIVE, DENSE, Counting()]
    found = np.array([[between(one, other) for other in rewards] for one in rewards])
    assert (found[:, None] <= found[:, :, None] + found[None] + 1e-12).all()
    assert (found[0, 1] > 0.01).all()
    assert (found[0, 1] < found[0, 2]).all()


def test_shaping_alone_is_at_no_distance(between):
    """Canonically shaped, a potential is constant: it correlates with nothing, and equals another one."""
    assert between(potential(GAMMA)) == [None] * 3
    squared = potential(GAMMA, lambda distance: distance**2)
    assert between(potential(GAMMA), squared) == NOTHING


@pytest.mark.parametrize(
    ("one", "other", "told"),
    [
        (np.array([1.0, 0.0]), "it is odd", "b: it is odd"),
        ("it is odd", None, "a: it is odd"),
        (np.array([1.0, 0.0]), None, SHAPING),
        (None, None, 0.0),
    ],
)
def test_what_has_no_distance_says_why(one, other, told):
    """Whose form is missing, or that one of the two is constant; two constants are the same."""
    assert compare_forms("a", {"EPIC": one}, "b", {"EPIC": other}) == {"EPIC": told}


def test_dard_does_not_ask_about_steps_that_cannot_be_done(short):
    """A reward that differs only in jumps no arm makes is the same to DARD, and another to EPIC."""

    def jumping(sample):
        jump = np.abs(sample.distance - sample.previous_distance) > 0.1
        return BASELINE((), sample)[1] + np.where(jump, sample.previous_distance**2, 0.0)

    changes = default_rng(0).uniform(-0.015, 0.015, (20, 40))
    distances = np.vstack([np.zeros(40), np.cumsum(changes, axis=0)]) + np.linspace(0.5, 2.0, 40)
    made = replace(short[0], states={"distance": distances}, events=0.0 * changes, running=changes < 1.0)
    found = apart(Paying(jumping), BASELINE, [made])
    assert found["DARD"] == pytest.approx(0.0, abs=1e-9)
    assert found["EPIC"] > 0.1

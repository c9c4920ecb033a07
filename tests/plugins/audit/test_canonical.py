"""The two canonical forms: against a slow computation, by hand, and where their steps may lead."""

import math
from bisect import bisect_right

import numpy as np
import pytest
from hypothesis import given, strategies as st
from numpy.random import default_rng
from numpy.testing import assert_allclose, assert_array_equal

from harness.payoff import Rollout
from harness.reward import Sample
from harness_plugins.audit.scripts import anywhere, canonical_values, nearby
from tests.payoff.conftest import Counting, Paying, named

GAMMA = 0.95
SAMPLES, GROUPS, CHANGES = 64, 32, 16
"""Distances of EPIC; groups of recorded steps, and changes of the distance that stand for those of a group."""


def wander(seed, episodes, steps, largest=0.02):
    """A made-up rollout: each step changes the distance by no more than `largest`, and every third episode ends."""
    rng = default_rng(seed)
    changes = rng.uniform(-largest, largest, (steps, episodes))
    distances = np.vstack([np.zeros(episodes), np.cumsum(changes, axis=0)]) + rng.uniform(0.4, 2.0, episodes)
    running = np.ones((steps, episodes), bool)
    running[steps // 2 :, ::3] = False
    return Rollout("wander", {"distance": distances}, np.zeros((steps, episodes)), running, np.zeros(episodes, bool))


class Slow:
    """DARD's form in plain loops over episodes, steps and changes, for one number at a time."""

    def __init__(self, reward, rollouts):
        """Sort the recorded steps by where they began."""
        self.reward, self.rollouts = reward, rollouts
        steps = sorted((before, after) for rollout in rollouts for before, after in self.recorded(rollout))
        self.lowest = min(after for _, after in steps)
        self.begins = sorted({steps[(len(steps) - 1) * group // GROUPS][0] for group in range(GROUPS)})
        self.groups = [[] for _ in self.begins]
        for before, after in steps:
            self.groups[self.group(before)].append(after - before)

    def recorded(self, rollout):
        """Before and after each step that belongs to an episode."""
        for step, episode in np.argwhere(rollout.running):
            yield rollout.distances[step, episode], rollout.distances[step + 1, episode]

    def group(self, distance):
        """The last group that begins at or below the distance, or the first."""
        return max(0, bisect_right(self.begins, distance) - 1)

    def after(self, distance, action):
        """Where a step from the distance leads."""
        ranked = sorted(self.groups[self.group(distance)])
        place = (action + 0.5) / CHANGES * (len(ranked) - 1)
        low, high = ranked[math.floor(place)], ranked[math.ceil(place)]
        return max(self.lowest, distance + low + (place - math.floor(place)) * (high - low))

    def pay(self, state, distance):
        """What the step from a state to a distance pays, and the state there."""
        begin, best, now, step, carry = state
        numbers = (begin, best, now, distance, distance - best, float(step))
        carry, value = self.reward(carry, Sample(*(np.array([number]) for number in numbers)))
        return float(value[0]), (begin, min(best, distance), distance, step + 1, carry)

    def values(self, gamma):
        """C of every recorded step."""
        return [value for rollout in self.rollouts for value in self.of_rollout(rollout, gamma)]

    def of_rollout(self, rollout, gamma):
        """Row by row, as the rollout holds them."""
        begins = rollout.distances[0]
        states = [(begin, begin, begin, 1, self.reward.initial_carry(np.array([begin]))) for begin in begins]
        for step, running in enumerate(rollout.running):
            for episode, counts in enumerate(running):
                state = states[episode]
                paid, following = self.pay(state, rollout.distances[step + 1, episode])
                states[episode] = following
                if counts:
                    yield paid + self.expected(state, following, gamma)

    def expected(self, state, following, gamma):
        """E[gamma R(s', D'') - R(s, D') - gamma R(S', D'')]."""
        total = 0.0
        for action in range(CHANGES):
            beyond = self.after(following[2], action)
            here, there = self.pay(state, self.after(state[2], action))
            total += gamma * self.pay(following, beyond)[0] - here - gamma * self.pay(there, beyond)[0]
        return total / CHANGES


@pytest.mark.parametrize("name", ["baseline", "arp", "counting", "late"])
def test_a_slow_double_loop_agrees(name):
    """DARD's form is the same one number at a time, also for a reward that remembers and one that counts steps."""
    late = Paying(lambda sample: sample.step**2 * sample.distance)
    known = {"counting": Counting(), "late": late}
    reward = known[name] if name in known else named(name)
    made = [wander(1, 9, 12), wander(2, 7, 8, 0.1)]
    values, _ = canonical_values(reward, made, GAMMA, nearby)
    assert_allclose(values, Slow(reward, made).values(GAMMA), rtol=1e-10, atol=1e-12)


def test_epic_by_hand(by_script):
    """C = R + gamma E[R(s', D)] - E[R(s, D)], here with R = d d' and so E[R(s, D)] = d times the mean of D."""
    product = Paying(lambda sample: sample.previous_distance * sample.distance)
    rollout = by_script["oscillate"]
    ahead = np.quantile(rollout.distances[1:].ravel(), (np.arange(SAMPLES) + 0.5) / SAMPLES).mean()
    before, after = rollout.distances[:-1], rollout.distances[1:]
    values, _ = canonical_values(product, [rollout], GAMMA, anywhere)
    assert values == pytest.approx((before * after + GAMMA * ahead * after - ahead * before).ravel())


@given(st.floats(0.0, 5.0))
def test_a_step_goes_no_farther_than_recorded_ones(made_reach, distance):
    """From any distance: by no more than the largest recorded change, never below the smallest recorded distance."""
    made, reach = made_reach
    after = reach.after(np.array([distance]))
    change = np.diff(made.distances, axis=0)[made.running]
    assert after.min() >= made.distances[1:][made.running].min() == reach.lowest
    assert ((after <= distance + change.max()) | (after == reach.lowest)).all()
    assert (after >= distance + change.min()).all()


@pytest.fixture(scope="module")
def made_reach():
    """A made-up rollout, and where its steps lead."""
    made = wander(3, 30, 20)
    return made, nearby([made])


def test_only_nearby_steps_count():
    """Steps from near that come nearer and steps from far that go away stay apart."""
    distances = np.array([[0.2, 0.3, 1.2, 1.3], [0.1, 0.2, 1.3, 1.4]])
    made = Rollout("made", {"distance": distances}, np.zeros((1, 4)), np.ones((1, 4), bool), np.zeros(4, bool))
    reach = nearby([made])
    assert reach.after(np.array([0.25])) == pytest.approx(0.15)
    assert reach.after(np.array([1.25])) == pytest.approx(1.35)


def test_a_lone_step_is_enough():
    """One recorded step, or many from the same distance, are a single group."""
    made = Rollout(
        "made", {"distance": np.array([[0.5], [0.4]])}, np.zeros((1, 1)), np.ones((1, 1), bool), np.zeros(1, bool)
    )
    assert nearby([made]).after(np.array([0.2, 0.5, 0.9])) == pytest.approx(
        np.repeat([[0.4], [0.4], [0.8]], CHANGES, axis=1)
    )


def test_steps_after_an_episode_do_not_count():
    """Neither form takes anything from them."""
    made = wander(4, 6, 10)
    changed = np.where(np.vstack([np.ones(6, bool), made.running]), made.distances, 1e3)
    other = Rollout("made", {"distance": changed}, made.events, made.running, made.reached)
    assert_array_equal(anywhere([other]).distances, anywhere([made]).distances)
    for one, two in zip(vars(nearby([other])).values(), vars(nearby([made])).values(), strict=True):
        assert_array_equal(one, two)

"""EPIC, DARD and STARC: what they leave unchanged, and what they come to where it can be written down."""

from dataclasses import replace
from itertools import product

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from numpy.random import default_rng
from numpy.testing import assert_array_equal

from harness.recorder.sealed import Walk
from harness_plugins.audit.distance import FORMS, centred_unit, distance_between
from harness_plugins.audit.transitions.canonical_forms import (
    cover,
    dard_form,
    epic_form,
    forms_of,
    one_by_one,
    starc_form,
)

STATES, ACTIONS = 4, 3

seeds = st.integers(0, 2**16)
gammas = st.floats(0.1, 0.99)


def table(seed):
    """A reward of each transition, any numbers."""
    return default_rng(seed).normal(size=(STATES, ACTIONS, STATES))


def asked(values, of):
    """The reward as a function of the rows of walks."""
    return one_by_one(lambda state, action, following: float(values[state, action, following]), of)


def walks(seed, lengths=(1, 2, 30)):
    """Episodes that jump anywhere."""
    rng = default_rng([seed, 1])
    return [Walk(rng.integers(STATES, size=n + 1).tolist(), rng.integers(ACTIONS, size=n).tolist()) for n in lengths]


def covered(of, seed=0):
    """Of these walks."""
    return cover([len(walk.actions) for walk in of], default_rng(seed))


def distances(one, other, gamma, seed):
    """By form."""
    met = walks(seed)
    forms = [forms_of(asked(values, met), gamma, covered(met, seed)) for values in (one, other)]
    return {form: distance_between(forms[0][form], forms[1][form]) for form in FORMS}


@given(seeds, gammas, st.floats(0.1, 10.0))
@settings(max_examples=25)
def test_scale_and_potential_shaping_are_no_distance(seed, gamma, scale):
    """Of any potential, in all three forms; an offset too."""
    phi = default_rng([seed, 2]).normal(size=STATES)
    reward = table(seed)
    shaped = scale * reward + gamma * phi[None, None, :] - phi[:, None, None] + 3.0
    assert distances(reward, shaped, gamma, seed) == pytest.approx(dict.fromkeys(FORMS, 0.0), abs=1e-6)


@given(seeds, seeds, gammas)
@settings(max_examples=25)
def test_distances_are_symmetric_and_from_0_to_1(one, other, gamma):
    """And the negative reward is the opposite."""
    there, back = (distances(table(a), table(b), gamma, one) for a, b in ((one, other), (other, one)))
    assert there == pytest.approx(back)
    assert all(0.0 <= value <= 1.0 for value in there.values())
    assert distances(table(one), -table(one), gamma, one) == pytest.approx(dict.fromkeys(FORMS, 1.0))


@given(seeds, gammas)
@settings(max_examples=10)
def test_epic_is_exact_where_every_transition_is_met(seed, gamma):
    """A table: the definition of Gleave et al., its constant included, by matrices."""
    rewards = table(seed), table(seed + 1)
    expected = []
    for values in rewards:
        mean = values.mean(axis=(1, 2))
        expected.append(values + gamma * mean[None, None, :] - mean[:, None, None] - gamma * values.mean())
    steps = list(product(range(STATES), range(ACTIONS), range(STATES)))
    met = [Walk([state, following], [action]) for state, action, following in steps]
    rows = {(action, following): 2 * number for number, (_, action, following) in enumerate(steps)}
    whole = replace(covered(met), actions=np.array([*rows.values()]), states=np.array([*rows.values()]) + 1)
    found = [epic_form(asked(values, met), gamma, whole) for values in rewards]
    assert found[0] + gamma * -rewards[0].mean() == pytest.approx(expected[0].ravel())
    rho = np.corrcoef(expected[0].ravel(), expected[1].ravel())[0, 1]
    assert distance_between(*(centred_unit(it, 1.0) for it in found)) == pytest.approx(np.sqrt((1.0 - rho) / 2.0))


def test_starc_takes_the_value_away():
    """Found again by a full matrix."""
    (walk,), values, gamma = walks(3, lengths=(20,)), table(3), 0.9
    matrix, paid = np.eye(21), np.zeros(21)
    beside, steps, counts = covered([walk]).near(np.arange(21))
    for t, k in zip(beside, steps, strict=True):
        matrix[t, k + 1] -= gamma / counts[t]
        paid[t] += values[walk.states[t], walk.actions[k], walk.states[k + 1]] / counts[t]
    value = np.linalg.solve(matrix, paid)
    own = [values[walk.states[t], walk.actions[t], walk.states[t + 1]] for t in range(20)]
    found = starc_form(asked(values, [walk]), gamma, covered([walk]))
    assert found == pytest.approx(np.array(own) + gamma * value[1:] - value[:-1])


def test_dard_sets_a_step_beside_those_near_in_time():
    """An episode of two steps, written out."""
    values, walk, gamma = table(1), Walk([0, 1, 2], [0, 1]), 0.5

    def reward(*step):
        return values[step]

    terms = [
        gamma * reward(1, 0, 2) - reward(0, 0, 1) - gamma * reward(1, 0, 2),
        gamma * reward(1, 1, 2) - reward(0, 1, 2) - gamma * reward(2, 1, 2),
    ]
    found = dard_form(asked(values, [walk]), gamma, replace(covered([walk]), chosen=np.array([0])))
    assert found == pytest.approx([reward(0, 0, 1) + np.mean(terms)])


def test_only_steps_near_in_time_count():
    """A reward that is another one far away changes nothing here."""
    walk = Walk(list(range(60)), [0] * 59)
    third = replace(covered([walk]), chosen=np.array([3]))
    plain, far = (lambda s, a, n: float(s * n)), (lambda s, a, n: float(s * n) if n < 40 else 1e9)
    assert dard_form(one_by_one(plain, [walk]), 0.9, third) == dard_form(one_by_one(far, [walk]), 0.9, third)
    assert third.near(np.array([3]))[1].tolist() == list(range(9))
    assert third.near(np.array([59]))[1].tolist() == list(range(54, 59))


@given(st.lists(st.integers(1, 20), min_size=1, max_size=5))
@settings(max_examples=25)
def test_steps_near_in_time_are_of_the_same_episode(lengths):
    """Every state has some, also the last one."""
    whole = cover(lengths, default_rng(0))
    rows = np.arange(sum(lengths) + len(lengths))
    beside, steps, counts = whole.near(rows)
    assert (counts > 0).all()
    assert_array_equal(whole.begin[steps], whole.begin[rows[beside]])
    assert (steps < whole.last[steps]).all()


def test_reward_that_is_nothing_but_shaping_has_no_distance():
    """To another one; to another such it is 0."""
    phi = np.arange(STATES) ** 2.0
    shaping = 0.9 * phi[None, None, :] - phi[:, None, None] + np.zeros((1, ACTIONS, 1))
    assert distances(shaping, table(0), 0.9, 0) == dict.fromkeys(FORMS)
    assert distances(shaping, 2.0 * shaping, 0.9, 0) == dict.fromkeys(FORMS, 0.0)


def test_starc_keeps_the_mean_and_epic_does_not():
    """Two forms that differ by a number are apart in STARC alone."""

    def pay(state, action, following):
        return float(action == 2)

    forms = forms_of(one_by_one(pay, walks(0)), 0.9, covered(walks(0)))
    epic, starc = forms["EPIC"], forms["STARC"]
    assert epic.mean() == pytest.approx(0.0, abs=1e-12)
    assert abs(starc.mean()) > 1e-3


def test_transitions_are_spread_over_all_walks():
    """At most 500 of them, each once, and as many samples as there should be."""
    found = cover([400, 1, 599], default_rng(0))
    assert len(np.unique(found.chosen)) == len(found.chosen) == 500
    assert [found.chosen[found.chosen <= 400][-1], found.chosen[-1]] == [pytest.approx(399, abs=2), 401 + 2 + 598]
    assert len(found.actions) == len(found.states) == 64

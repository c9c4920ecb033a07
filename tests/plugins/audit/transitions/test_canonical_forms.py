"""EPIC, DARD and STARC: what they leave unchanged, and what they come to where it can be written down."""

from itertools import product

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from numpy.random import default_rng

from harness.recorder.sealed import Walk
from harness_plugins.audit.distance import FORMS, centred_unit, distance_between
from harness_plugins.audit.transitions.canonical_forms import (
    Coverage,
    dard_form,
    draw_coverages,
    epic_form,
    forms_of,
    near,
    one_by_one,
    starc_form,
)

STATES, ACTIONS = 4, 3

seeds = st.integers(0, 2**16)
gammas = st.floats(0.1, 0.99)


def table(seed):
    """A reward of each transition, any numbers."""
    return default_rng(seed).normal(size=(STATES, ACTIONS, STATES))


def asked(values):
    """The reward as a function."""
    return one_by_one(lambda state, action, following: float(values[state, action, following]))


def walks(seed, lengths=(1, 2, 30)):
    """Episodes that jump anywhere."""
    rng = default_rng([seed, 1])
    return [Walk(rng.integers(STATES, size=n + 1).tolist(), rng.integers(ACTIONS, size=n).tolist()) for n in lengths]


def coverages(seed, **given):
    """Of these walks."""
    return draw_coverages(walks(seed, **given), default_rng(seed))


def distances(one, other, gamma, seed):
    """By form."""
    forms = [forms_of(asked(values), gamma, coverages(seed)) for values in (one, other)]
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
    actions, states = zip(*list(product(range(ACTIONS), range(STATES))), strict=True)
    met = [
        Coverage(Walk([state, following], [action]), [0], actions, states)
        for state, action, following in product(range(STATES), range(ACTIONS), range(STATES))
    ]
    found = [np.concatenate([epic_form(asked(values), gamma, it) for it in met]) for values in rewards]
    assert found[0] + gamma * -rewards[0].mean() == pytest.approx(expected[0].ravel())
    rho = np.corrcoef(expected[0].ravel(), expected[1].ravel())[0, 1]
    assert distance_between(*(centred_unit(it, 1.0) for it in found)) == pytest.approx(np.sqrt((1.0 - rho) / 2.0))


def test_starc_takes_the_value_away():
    """Found again by a full matrix."""
    (walk,), values, gamma = walks(3, lengths=(20,)), table(3), 0.9
    matrix, paid = np.eye(21), np.zeros(21)
    for t in range(21):
        for k in near(t, 20):
            matrix[t, k + 1] -= gamma / len(near(t, 20))
            paid[t] += values[walk.states[t], walk.actions[k], walk.states[k + 1]] / len(near(t, 20))
    value = np.linalg.solve(matrix, paid)
    own = [values[walk.states[t], walk.actions[t], walk.states[t + 1]] for t in range(20)]
    found = starc_form(asked(values), gamma, Coverage(walk, range(20), [], []))
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
    found = dard_form(asked(values), gamma, Coverage(walk, [0], [], []))
    assert found == pytest.approx([reward(0, 0, 1) + np.mean(terms)])


def test_only_steps_near_in_time_count():
    """A reward that is another one far away changes nothing here."""
    walk = Walk(list(range(60)), [0] * 59)
    plain, far = (lambda s, a, n: float(s * n)), (lambda s, a, n: float(s * n) if n < 40 else 1e9)
    assert dard_form(one_by_one(plain), 0.9, Coverage(walk, [3], [], [])) == dard_form(
        one_by_one(far), 0.9, Coverage(walk, [3], [], [])
    )
    assert list(near(3, 59)) == list(range(9))
    assert list(near(59, 59)) == list(range(54, 59))


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

    forms = forms_of(one_by_one(pay), 0.9, coverages(0))
    epic, starc = forms["EPIC"], forms["STARC"]
    assert epic.mean() == pytest.approx(0.0, abs=1e-12)
    assert abs(starc.mean()) > 1e-3


def test_transitions_are_spread_over_all_walks():
    """At most 500 of them, each once, and EPIC's samples the same for all."""
    found = coverages(0, lengths=(400, 1, 599))
    assert sum(len(it.chosen) for it in found) == 500
    assert [it.chosen[-1] for it in (found[0], found[2])] == [pytest.approx(399, abs=2), 598]
    assert found[0].actions is found[2].actions
    assert len(found[0].states) == 64

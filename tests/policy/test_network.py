"""What all networks have in common: layers, normalisation, the batch."""

import math

import numpy as np
import pytest
from numpy.random import default_rng
from numpy.testing import assert_allclose, assert_array_equal

from harness.policy import Categorical, Deterministic, Gaussian, Greedy, SquashedGaussian

CONTINUOUS = (SquashedGaussian, Gaussian, Deterministic)
NETWORKS = (*CONTINUOUS, Greedy, Categorical)


def _slow_head(policy, observation, head):
    """A head on one observation, in loops and double precision."""

    def linear(values, layer):
        weight, bias = policy.weights[f"{layer}.weight"].tolist(), policy.weights[f"{layer}.bias"].tolist()
        return [sum(w * v for w, v in zip(row, values, strict=True)) + b for row, b in zip(weight, bias, strict=True)]

    values, index = observation, 0
    if "observation.mean" in policy.weights:
        mean, std = (policy.weights[f"observation.{part}"].tolist() for part in ("mean", "std"))
        values = [(value - m) / s for value, m, s in zip(values, mean, std, strict=True)]
    activation = {"relu": lambda value: max(value, 0.0), "tanh": math.tanh}[policy.activation]
    while f"hidden.{index}.weight" in policy.weights:
        values = [activation(value) for value in linear(values, f"hidden.{index}")]
        index += 1
    return linear(values, head)


def _slow_action(policy, observation):
    """The action of one observation without noise."""
    values = _slow_head(policy, observation, policy.heads[0])
    if isinstance(policy, Greedy | Categorical):
        return values.index(max(values))
    ends = list(zip(values, policy.action_low, policy.action_high, strict=True))
    if isinstance(policy, Gaussian):
        return [min(max(value, low), high) for value, low, high in ends]
    return [low + (math.tanh(value) + 1.0) / 2.0 * (high - low) for value, low, high in ends]


def test_act_agrees_with_a_plain_computation(make_network, observations, subtests):
    """Layer by layer in loops, the action is the same, whether observations are scaled first or not."""
    for kind in NETWORKS:
        for layers in [0, 1, 3]:
            for activation in ["relu", "tanh"]:
                for is_normalised in [False, True]:
                    with subtests.test(kind=kind, layers=layers, activation=activation, is_normalised=is_normalised):
                        policy = make_network(
                            kind, layers=layers, activation=activation, is_normalised=is_normalised, low=-2.0, high=3.0
                        )
                        expected = [_slow_action(policy, observation) for observation in observations(20).tolist()]
                        assert_allclose(policy.act(observations(20)), expected, atol=1e-5)


@pytest.mark.parametrize("kind", NETWORKS)
def test_each_env_is_on_its_own(make_network, observations, kind):
    """An observation gives the same action alone as in a batch."""
    policy = make_network(kind)
    alone = np.concatenate([policy.act(row[None]) for row in observations()])
    assert_allclose(alone, policy.act(observations()), atol=1e-6)


@pytest.mark.parametrize("kind", NETWORKS)
def test_act_leaves_the_observations_alone(make_network, observations, kind):
    """They belong to the env."""
    seen = observations()
    make_network(kind, layers=0, is_normalised=True).act(seen, default_rng(0))
    assert_array_equal(seen, observations())


@pytest.mark.parametrize("kind", NETWORKS)
def test_one_action_is_deterministic(make_network, observations, kind):
    """Without a generator nothing is drawn, and nothing is remembered."""
    policy = make_network(kind)
    first = policy.act(observations()).copy()
    assert_array_equal(policy.act(observations()), first)


def test_continuous_actions_are_float32_rows(make_network, observations, subtests):
    """One row for each env of the batch."""
    for kind in CONTINUOUS:
        for seed in [None, 0]:
            with subtests.test(kind=kind, seed=seed):
                rng = None if seed is None else default_rng(seed)
                actions = make_network(kind).act(observations(7), rng)
                assert (actions.shape, actions.dtype) == ((7, 2), np.float32)


@pytest.mark.parametrize("kind", [Greedy, Categorical])
@pytest.mark.parametrize("seed", [None, 0])
def test_choices_are_whole_numbers(make_network, observations, kind, seed):
    """One for each env of the batch."""
    rng = None if seed is None else default_rng(seed)
    choices = make_network(kind).act(observations(7), rng)
    assert (choices.shape, choices.dtype) == ((7,), np.int64)


@pytest.mark.parametrize("kind", CONTINUOUS)
def test_drawn_actions_come_from_the_generator(make_network, observations, kind):
    """Equal generators draw equal actions, others draw others, and none is the one without noise."""
    policy = make_network(kind, scale=0.1)
    drawn = [policy.act(observations(), default_rng(seed)) for seed in (3, 3, 4)]
    assert_array_equal(drawn[0], drawn[1])
    assert (drawn[0] != drawn[2]).any()
    assert (drawn[0] != policy.act(observations())).any()


@pytest.mark.parametrize("kind", NETWORKS)
def test_floor_has_the_same_actions(make_network, observations, kind):
    """What a policy is measured against chooses among the same actions."""
    policy = make_network(kind, low=-0.25, high=0.5)
    ours, floor = (each.act(observations(100)) for each in (policy, policy.floor()))
    assert (ours.shape, ours.dtype) == (floor.shape, floor.dtype)
    expected = [0, 2] if issubclass(kind, Greedy | Categorical) else [-0.25, 0.5]
    assert_allclose([floor.min(), floor.max()], expected, atol=0.05)

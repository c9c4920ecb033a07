"""Exported models: other programs get the actions that the policy gives."""

import json
from itertools import product

import numpy as np
import onnx
import onnxruntime
import pytest
from hypothesis import given, strategies as st
from numpy.random import default_rng
from numpy.testing import assert_allclose

from harness.policy import Categorical, Deterministic, Gaussian, Greedy, SquashedGaussian
from harness_plugins.exporters import onnx_model

CARD = {"format": 2, "algorithm": "wander", "cell": {"seed": 3, "reward": "¼ of it"}}


def _loaded(policy):
    """What another program does with the model."""
    session = onnxruntime.InferenceSession(onnx_model.model_of(policy, CARD), providers=["CPUExecutionProvider"])
    return lambda seen: session.run(["action"], {"observation": seen})[0]


NETWORKS = (SquashedGaussian, Gaussian, Deterministic, Greedy, Categorical)
every_kind = pytest.mark.parametrize("kind", NETWORKS)


def _observations(count, scale):
    return (scale * default_rng(2).normal(size=(count, 5))).astype(np.float32)


def _assert_equal(policy, seen):
    actions, expected = _loaded(policy)(seen), policy.act(seen)
    assert (actions.shape, actions.dtype) == (expected.shape, expected.dtype)
    assert_allclose(actions, expected, rtol=0.0, atol=1e-5)


@every_kind
def test_model_acts_as_the_policy(make_network, kind, subtests):
    """To 1e-5 on random observations, scaling of observations and actions included."""
    for layers, activation, is_normalised in product([0, 1, 3], ["relu", "tanh"], [False, True]):
        built = {"layers": layers, "activation": activation, "is_normalised": is_normalised}
        with subtests.test(**built):
            _assert_equal(make_network(kind, **built, low=-0.5, high=2.0), _observations(200, 1.0))


EXTREMES = np.array(
    [*np.vstack([np.eye(5), -np.eye(5)]) * 1e6, [0.0] * 5, [-0.0] * 5, [1e6] * 5, [-1e6] * 5, [1e-30] * 5], np.float32
)


@every_kind
def test_model_acts_as_the_policy_far_out(make_network, kind, subtests):
    """To 1e-5 on observations that saturate the network, on zeros and on denormal-small ones."""
    for activation, is_normalised in product(["relu", "tanh"], [False, True]):
        built = {"activation": activation, "is_normalised": is_normalised}
        with subtests.test(**built):
            _assert_equal(make_network(kind, **built, low=-0.5, high=2.0), EXTREMES)


@given(
    kind=st.sampled_from(NETWORKS),
    seed=st.integers(0, 1000),
    ends=st.tuples(st.floats(-5, 5, width=32), st.floats(-5, 5, width=32)),
    count=st.integers(1, 5),
)
def test_any_policy_is_exported_right(make_network, kind, seed, ends, count):
    """Whatever the weights, the box and the batch."""
    policy = make_network(kind, seed, is_normalised=bool(seed % 2), low=min(ends), high=max(ends))
    _assert_equal(policy, _observations(count, 1.0))


@pytest.mark.parametrize("count", [0, 1, 1000])
def test_any_batch_is_taken(make_network, count):
    """One model for all sizes, none included."""
    _assert_equal(make_network(SquashedGaussian), _observations(count, 1.0))


@pytest.mark.parametrize("kind", [SquashedGaussian, Gaussian, Deterministic])
def test_actions_of_a_model_stay_in_the_box(make_network, kind):
    """Bounds included, where high - low is rounded."""
    policy = make_network(kind, low=-9.899999618530273, high=0.10000000149011612, scale=30.0)
    actions = _loaded(policy)(_observations(100, 10.0))
    assert actions.min() >= np.float32(policy.action_low[0])
    assert actions.max() <= np.float32(policy.action_high[0])


def test_onnx_model_has_names_and_the_card(make_network):
    """A reader finds input, output, batch axis and the card in the file alone."""
    model = onnx.load_from_string(onnx_model.model_of(make_network(Gaussian), CARD))
    ends = [*model.graph.input, *model.graph.output]
    shapes = [[axis.dim_param or axis.dim_value for axis in end.type.tensor_type.shape.dim] for end in ends]
    assert [end.name for end in ends] == ["observation", "action"]
    assert shapes == [["batch", 5], ["batch", 2]]
    (entry,) = model.metadata_props
    assert (entry.key, json.loads(entry.value)) == ("card", CARD)


def test_choices_are_a_row_of_whole_numbers(make_network):
    """The action of a policy that chooses is (batch,) of int64."""
    (action,) = onnx.load_from_string(onnx_model.model_of(make_network(Greedy), CARD)).graph.output
    assert action.type.tensor_type.elem_type == onnx.TensorProto.INT64
    assert [axis.dim_param for axis in action.type.tensor_type.shape.dim] == ["batch"]


def test_onnx_model_runs_where_programs_are_older(make_network):
    """It asks for no more than programs of 2022 know."""
    model = onnx.load_from_string(onnx_model.model_of(make_network(SquashedGaussian), CARD))
    assert (model.opset_import[0].version, model.ir_version) == (17, 8)


def test_same_policy_gives_the_same_file(make_network):
    """Byte for byte, so that files can be compared."""
    first, second = (onnx_model.model_of(make_network(Greedy), CARD) for _ in range(2))
    assert first == second

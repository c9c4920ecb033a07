"""An ONNX model, made of a policy's arrays alone."""

import json
from collections.abc import Mapping
from typing import Any

import numpy as np
import onnx
from onnx import TensorProto, helper, numpy_helper

from harness.policy.policy import MEAN, STD, ContinuousNetwork, Network

OPSET, IR_VERSION = 17, 8
"""Versions of ONNX from 2022. They have all that these models need, and programs of that age can read them."""
OBSERVATION, ACTION = "observation", "action"


class Graph:
    """Nodes one after another. Each takes the output of the node before it, and constants."""

    def __init__(self, first: str) -> None:
        self.nodes: list[onnx.NodeProto] = []
        self.constants: dict[str, onnx.TensorProto] = {}
        self._last = first

    def add(self, operator: str, constants: Mapping[str, np.ndarray] | None = None, **attributes: Any) -> None:
        """Append a node."""
        arrays = {name: np.ascontiguousarray(array) for name, array in (constants or {}).items()}
        self.constants |= {name: numpy_helper.from_array(array, name) for name, array in arrays.items()}
        output = f"{len(self.nodes)}.{operator}"
        self.nodes.append(helper.make_node(operator, [self._last, *arrays], [output], **attributes))
        self._last = output

    def end(self, name: str) -> None:
        """Give the last output its name."""
        self.nodes[-1].output[0] = name


def model_of(policy: Network, card: Mapping[str, Any]) -> bytes:
    """The bytes of a model's file. Its metadata has the policy's card, under ``card``.

    The input ``observation`` is (batch, observation_size) of float32. The output ``action`` is (batch, action_size) of
    float32, or (batch,) of int64 if the policy chooses between discrete actions.
    """
    graph = Graph(OBSERVATION)
    _add_network(graph, policy)
    if isinstance(policy, ContinuousNetwork):
        _add_box(graph, policy)
        action = helper.make_tensor_value_info(ACTION, TensorProto.FLOAT, ["batch", len(policy.action_low)])
    else:
        graph.add("ArgMax", axis=1, keepdims=0)
        action = helper.make_tensor_value_info(ACTION, TensorProto.INT64, ["batch"])
    graph.end(ACTION)
    seen = helper.make_tensor_value_info(OBSERVATION, TensorProto.FLOAT, ["batch", policy.observation_size])
    made = helper.make_graph(graph.nodes, "policy", [seen], [action], list(graph.constants.values()))
    model = helper.make_model(
        made, producer_name="fd100-harness", opset_imports=[helper.make_opsetid("", OPSET)], ir_version=IR_VERSION
    )
    helper.set_model_props(model, {"card": json.dumps(card)})
    onnx.checker.check_model(model)
    return bytes(model.SerializeToString())


def _add_network(graph: Graph, policy: Network) -> None:
    """Add the nodes that lead from the observation to the network's first head."""
    if policy.is_normalised:
        graph.add("Sub", {MEAN: policy.weights[MEAN]})
        graph.add("Div", {STD: policy.weights[STD]})
    for index in range(policy.depth):
        _add_linear(graph, policy, f"hidden.{index}")
        graph.add({"relu": "Relu", "tanh": "Tanh"}[policy.activation])
    _add_linear(graph, policy, policy.heads[0])


def _add_linear(graph: Graph, policy: Network, layer: str) -> None:
    graph.add("Gemm", {name: policy.weights[name] for name in (f"{layer}.weight", f"{layer}.bias")}, transB=1)


def _add_box(graph: Graph, policy: ContinuousNetwork) -> None:
    low, high, half = policy.bounds
    if policy.squashes:
        graph.add("Tanh")
        graph.add("Add", {"one": np.ones(1, np.float32)})
        graph.add("Mul", {"action.half": half})
        graph.add("Add", {"action.low": low})
    graph.add("Max", {"action.low": low})
    graph.add("Min", {"action.high": high})

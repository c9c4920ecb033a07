"""Every export check has a wrong export that fails it; and the sentence says what would explain it."""

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from harness.policy import Greedy, SquashedGaussian
from harness_plugins.kit import EXPORT_CHECKS, Check, check_export, exports, violations

SEEN, ACTIONS = 28, 6
"""Numbers of an observation of the kit's easy task, and of an action."""


def network(rng: np.random.Generator) -> dict[str, np.ndarray]:
    """The weights of a small one, whose actions fill the box."""
    shapes = {"hidden.0.weight": (8, SEEN), "hidden.0.bias": (8,), "mean.weight": (ACTIONS, 8), "mean.bias": (ACTIONS,)}
    shapes |= {"log_std.weight": (ACTIONS, 8), "log_std.bias": (ACTIONS,)}
    return {name: rng.normal(0.0, 0.3, shape).astype(np.float32) for name, shape in shapes.items()}


BOX = (-1.0,) * ACTIONS, (1.0,) * ACTIONS
POLICY = SquashedGaussian(network(np.random.default_rng(0)), "tanh", *BOX)


class SavesCarelessly(SquashedGaussian):
    """What it saves is rounded."""

    def save(self, folder: Path, cell: Any = None) -> None:
        """Write another policy."""
        rounded = {name: np.float32(np.float16(weight)) for name, weight in self.weights.items()}
        replace(POLICY, weights=rounded).save(folder, cell)


def with_weights(**factors: float) -> SquashedGaussian:
    """The policy with some weights scaled."""
    scaled = {
        name: np.float32(factors.get(name.replace(".", "_"), 1.0)) * array for name, array in POLICY.weights.items()
    }
    return replace(POLICY, weights=scaled)


def reversed_outputs() -> SquashedGaussian:
    """The policy with the rows of its head in reverse order."""
    heads = {name: np.ascontiguousarray(POLICY.weights[name][::-1]) for name in ("mean.weight", "mean.bias")}
    return replace(POLICY, weights={**POLICY.weights, **heads})


def half_the_box() -> SquashedGaussian:
    """The policy of an env with a smaller box."""
    return replace(POLICY, action_low=(-0.5,) * ACTIONS, action_high=(0.5,) * ACTIONS)


MUTANTS: dict[str, tuple[Callable[[], Any], Check, str]] = {
    "outputs reversed": (reversed_outputs, exports.both_act_the_same, "in reverse order"),
    "bias dropped": (partial(with_weights, mean_bias=0.0), exports.both_act_the_same, "action"),
    "hidden bias dropped": (partial(with_weights, hidden_0_bias=0.0), exports.both_act_the_same, "action"),
    "weights x 3": (partial(with_weights, mean_weight=3.0, mean_bias=3.0), exports.both_act_the_same, "action"),
    "weights 1 % off": (partial(with_weights, mean_weight=1.01), exports.both_act_the_same, "action"),
    "other sign": (partial(with_weights, mean_weight=-1.0, mean_bias=-1.0), exports.both_act_the_same, "other sign"),
    "half the box": (half_the_box, exports.both_act_the_same, "the model's are 2 times as large"),
    "other activation": (lambda: replace(POLICY, activation="relu"), exports.both_act_the_same, "action"),
    "no squashing": (lambda: Unsquashed(POLICY), exports.both_act_the_same, "action"),
    "one action for all": (lambda: FirstOnly(POLICY), exports.both_give_actions_of_one_shape, "the model (96, 6)"),
    "saved carelessly": (
        lambda: SavesCarelessly(POLICY.weights, "tanh", *BOX), exports.it_acts_the_same_from_its_folder, "differently",
    ),
}  # fmt: skip


class Unsquashed:
    """Clips where it should squash."""

    def __init__(self, policy: SquashedGaussian) -> None:
        self.policy = policy

    def act(self, seen: np.ndarray, rng: Any = None) -> np.ndarray:
        """Without tanh."""
        return np.clip(self.policy.head(self.policy.hidden(seen), "mean"), -1.0, 1.0)

    def save(self, folder: Path) -> None:
        """Not looked at."""
        self.policy.save(folder)


class FirstOnly(Unsquashed):
    """Acts for the first observation alone."""

    def act(self, seen: np.ndarray, rng: Any = None) -> np.ndarray:
        """Of one row."""
        return self.policy.act(seen[:1])


def test_wrong_export_is_found(subtests: pytest.Subtests):
    """By its check, whose sentence says what would explain it."""
    for name, (make, check, words) in MUTANTS.items():
        with subtests.test(name=name):
            (violation,) = violations([check], make(), POLICY.act, exports._some())
            assert words in violation.sentence


def test_every_check_has_a_mutant():
    """No check is without a wrong export."""
    assert {check for _, check, _ in MUTANTS.values()} == set(EXPORT_CHECKS)


def test_a_right_export_passes():
    """Another library's rounding is allowed for."""
    assert check_export(POLICY, lambda seen: POLICY.act(seen) + np.float32(1e-5)) is None


def test_choices_are_compared_too():
    """Where a policy chooses, it chooses the same."""
    weights = {"value.weight": np.eye(3, SEEN, dtype=np.float32), "value.bias": np.zeros(3, np.float32)}
    greedy = Greedy(weights, "relu", 3)
    assert check_export(greedy, lambda seen: seen[:, :3].argmax(axis=1)) is None
    (violation,) = violations(
        [exports.both_act_the_same], greedy, lambda seen: seen[:, :3].argmin(axis=1), exports._some()
    )
    assert "the policy chooses differently than the model" in violation.sentence

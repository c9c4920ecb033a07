"""What a policy must satisfy that was made from another library's model, or a model that was made from a policy.

Each check takes the policy and `act`, which says what the other one does: a function from observations, (count, size)
of float32, to its actions without noise, (count, action_size), or (count,) where it chooses.
"""

import tempfile
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np

from harness.arrays import Float, Float32
from harness.policy import Policy, load_policy

from .contract import Check, check, raise_first, require
from .trainings import observations

Act: TypeAlias = Callable[[Float32], Any]
TOLERANCE = 1e-3
"""The tolerance of an action, as a share of half the box: two libraries round each layer in their own way."""
LARGE = 3.0
"""By how much the drawn observations are larger than those of the easy task: so that no part of a network is idle."""


def check_export(policy: Policy, act: Act, seen: Float32 | None = None) -> None:
    """Run all `EXPORT_CHECKS`.

    Args:
        policy: What the algorithm yields.
        act: What the library's own model does without noise,
            ``lambda seen: model.predict(seen, deterministic=True)[0]``.
        seen: Observations to compare at, (count, size); by default those of the kit's easy task with the FD100, and
            larger ones.

    Raises:
        ContractViolation: At the first check that fails.
    """
    raise_first(EXPORT_CHECKS, policy, act, _some() if seen is None else seen)


@check("export-shape")
def both_give_actions_of_one_shape(policy: Policy, act: Act, seen: Float32) -> None:
    """For many observations and for one, policy and model give equally many finite actions of one shape."""
    for some in (seen, seen[:1]):
        own, other = policy.act(some), np.asarray(act(some))
        given = f"{len(some)} observations"
        require(own.shape == other.shape, f"for {given} the policy gives {own.shape}, the model {other.shape}")
        require(np.isfinite(other).all(), f"for {given} the model's actions are not all finite")


@check("export-actions")
def both_act_the_same(policy: Policy, act: Act, seen: Float32) -> None:
    """At every observation the policy takes the same action as the model without noise."""
    own, other = policy.act(seen), np.asarray(act(seen))
    if own.shape != other.shape:
        return  # another check says so
    if own.ndim == 1:
        differing = np.count_nonzero(own != other)
        told = f"at {differing} of {len(seen)} observations the policy chooses differently than the model"
        first = int((own != other).argmax())
        require(differing <= TOLERANCE * len(seen), f"{told}, first {own[first]} instead of {other[first]}")
        return
    error = np.abs(own - other) / _half_of_box(policy)
    row, number = np.unravel_index(int(error.argmax()), error.shape)
    require(
        error[row, number] <= TOLERANCE,  # what is no number is not
        f"action {number + 1} of the policy is {own[row, number]:.3f} where that of the model is "
        f"{other[row, number]:.3f}; they differ by {np.abs(own - other).mean():.2g} on average{_guess(own, other)}",
    )


@check("export-saved")
def it_acts_the_same_from_its_folder(policy: Policy, act: Act, seen: Float32) -> None:
    """A policy that is read from its folder acts like the one that was written, bit for bit."""
    with tempfile.TemporaryDirectory() as folder:
        policy.save(Path(folder) / "policy")
        loaded = load_policy(Path(folder) / "policy")
    require(
        np.array_equal(policy.act(seen), loaded.act(seen)), "the policy that is read from its folder acts differently"
    )


EXPORT_CHECKS: tuple[Check, ...] = (
    both_give_actions_of_one_shape,
    both_act_the_same,
    it_acts_the_same_from_its_folder,
)


def _some() -> Float32:
    """Observations of the easy task, and ones around them that are larger."""
    seen = observations()
    drawn = seen + np.random.default_rng(0).normal(0.0, LARGE, seen.shape)
    return np.concatenate([seen, drawn.astype(np.float32)])


def _half_of_box(policy: Policy) -> Float:
    """Half of what lies between the ends of each action; 1 where the policy does not say."""
    low, high = getattr(policy, "action_low", None), getattr(policy, "action_high", None)
    half: Float = np.ones(1) if low is None or high is None else 0.5 * (np.array(high) - np.array(low))
    return half


def _guess(own: Float, other: Float) -> str:
    """What would explain the difference; empty where nothing simple does."""
    near = partial(np.allclose, b=other, atol=TOLERANCE)
    if near(own[:, ::-1]):
        return ": its actions come in reverse order"
    if near(-own):
        return ": its actions have the other sign"
    with np.errstate(divide="ignore", invalid="ignore"):
        factor = float(np.nanmedian(other / own))
    if np.isfinite(factor) and near(factor * own):
        return f": the model's are {factor:.3g} times as large"
    offset = np.median(other - own, axis=0)
    if near(own + offset):
        return ": the difference is the same at all observations, as of a bias that is left out"
    return ""

"""Numbers to watch, by the names that they have in Unity ML-Agents' statistics."""

from collections.abc import Mapping
from typing import Any

NAMES = {
    "train/actor_loss": ("Losses/Policy Loss", 1.0),
    "train/policy_gradient_loss": ("Losses/Policy Loss", 1.0),
    "train/critic_loss": ("Losses/Value Loss", 1.0),
    "train/value_loss": ("Losses/Value Loss", 1.0),
    "train/loss": ("Losses/Value Loss", 1.0),
    "train/entropy_loss": ("Policy/Entropy", -1.0),
    "train/ent_coef": ("Policy/Continuous Entropy Coeff", 1.0),
    "train/learning_rate": ("Policy/Learning Rate", 1.0),
    "rollout/exploration_rate": ("Policy/Epsilon", 1.0),
}
"""Names of the library's logger, each with the name that is used here and a factor."""


def losses(logged: Mapping[str, Any]) -> dict[str, float]:
    """The values that were logged last, by the names in `NAMES`."""
    told = _without_totals(logged)
    return {name: factor * float(logged[key]) for key, (name, factor) in NAMES.items() if key in told}


def _without_totals(logged: Mapping[str, Any]) -> set[str]:
    """The logged names without PPO's ``train/loss``, which is the sum of the other losses. DQN logs only that one."""
    return {key for key in logged if key != "train/loss" or "train/value_loss" not in logged}

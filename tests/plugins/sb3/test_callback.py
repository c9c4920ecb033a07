"""What a training by stable-baselines3 tells, and when it ends."""

from collections.abc import Mapping
from types import SimpleNamespace
from typing import Any

import pytest

from harness.algorithm import Progress
from harness_plugins.sb3 import ProgressCallback
from tests.plugins.test_sb3 import adapt, stand


class Told(Progress):
    """Keeps what it is told."""

    def __init__(self) -> None:
        self.policies: list[tuple[int, Any]] = []
        self.told: list[tuple[int, Mapping[str, float]]] = []

    def policy(self, steps, make):
        """Kept."""
        self.policies.append((steps, make()))

    def scalars(self, steps, values):
        """Kept."""
        self.told.append((steps, values))


def watch(env, told, budget=10_000, **logged):
    """The callback of a model that logged something, before its first step; an update comes every 12 decisions."""
    callback = ProgressCallback(env, told, budget, lambda model: f"policy of {model.name}", 12)  # type: ignore[arg-type, return-value]
    names = {f"train/{name}": value for name, value in logged.items()}
    callback.model = SimpleNamespace(name="the model", logger=SimpleNamespace(name_to_value=names))
    return callback


def test_policy_is_offered_at_every_step_and_at_the_end():
    """Whoever watches decides when an evaluation is due."""
    told, adapter = Told(), adapt()
    callback = watch(adapter.env, told)
    for _ in range(2):
        stand(adapter)
        callback._on_step()
    callback._on_training_end()
    assert told.policies == [(steps, "policy of the model") for steps in (3, 6, 6)]


@pytest.mark.parametrize(("decisions", "goes_on"), [(9, False), (12, True), (15, False)])
def test_training_ends_at_its_budget(decisions, goes_on):
    """No further step is taken; a rollout that is complete is still learned from."""
    adapter = adapt()
    callback = watch(adapter.env, Told(), budget=decisions)
    for _ in range(decisions // 3):
        assert callback._on_step()
        stand(adapter)
    callback.num_timesteps = decisions
    assert callback._on_step() is goes_on


def test_scalars_are_told_every_thousand_steps():
    """Under the names of ML-Agents, as they are then; in the end only what is news."""
    told, adapter = Told(), adapt(num_envs=100)
    callback = watch(adapter.env, told, actor_loss=0.5, entropy_loss=-3.0, unknown=1.0)
    for _ in range(25):
        stand(adapter)
        callback._on_step()
    callback._on_training_end()
    callback._on_training_end()
    assert told.told == [(n, {"Losses/Policy Loss": 0.5, "Policy/Entropy": 3.0}) for n in (1000, 2000, 2500)]

"""What the tests of several algorithms need."""

from typing import Any

import pytest
import stable_baselines3

from harness_plugins.sb3 import double


@pytest.fixture
def models(monkeypatch):
    """The models that stable-baselines3 makes while the test runs."""
    made = []

    def watched(library):
        class Watched(library):  # type: ignore[misc]
            def __init__(self, *args: Any, **kwargs: Any) -> None:
                super().__init__(*args, **kwargs)
                made.append(self)

        return Watched

    for module, name in [*((stable_baselines3, name) for name in ("SAC", "TD3", "PPO", "DQN")), (double, "DoubleDQN")]:
        monkeypatch.setattr(module, name, watched(getattr(module, name)))
    return made

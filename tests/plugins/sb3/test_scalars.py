"""Numbers to watch."""

import numpy as np
import pytest

from harness_plugins.sb3.scalars import Scalars


def test_scalars_of_episodes_are_means_since_the_last_time():
    """Of the episodes that ended; nothing is told where none did."""
    scalars = Scalars()
    infos = [{"episode": {"r": -2.0, "l": 10}}, {}, {"episode": {"r": 1.0, "l": 5}}]
    scalars.watch(infos, np.array([True, False, True]))
    assert scalars.take({}) == {"Environment/Cumulative Reward": -0.5, "Environment/Episode Length": 7.5}
    assert scalars.take({}) == {}


@pytest.mark.parametrize(
    ("logged", "told"), [({"train/loss": 2.0}, 2.0), ({"train/loss": 2.0, "train/value_loss": 3.0}, 3.0)]
)
def test_value_loss_is_the_value_networks(logged: dict[str, float], told: float):
    """DQN has one loss; PPO's is a sum, of which the value network's is a term."""
    assert Scalars().take(logged) == {"Losses/Value Loss": told}

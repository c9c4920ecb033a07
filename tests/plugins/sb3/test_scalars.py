"""Numbers to watch."""

import pytest

from harness_plugins.sb3.callback import losses


@pytest.mark.parametrize(
    ("logged", "told"), [({"train/loss": 2.0}, 2.0), ({"train/loss": 2.0, "train/value_loss": 3.0}, 3.0)]
)
def test_value_loss_is_the_value_networks(logged, told):
    """DQN has one loss; PPO's is a sum, of which the value network's is a term."""
    assert losses(logged) == {"Losses/Value Loss": told}

"""Built-in rewards."""

from ..announced import register_rewards as register_rewards

"""What the algorithms of stable-baselines3 share: its view of our vector env, and its progress."""

from harness_plugins.sb3.callback import SilentProgress
from harness_plugins.sb3.vec_env import VecEnvAdapter

__all__ = ["SilentProgress", "VecEnvAdapter"]

"""What the algorithms of stable-baselines3 share: their training, and the policies that come of it.

The modules are imported one by one: `q_learning` is light, the others import torch.
"""

SOURCES = ("harness_plugins.sb3", "harness_plugins.torch_state", "harness_plugins.episode_means")
"""The modules that the algorithms work in, besides their own."""

"""What the algorithms of stable-baselines3 share: their training, and the policies that come of it.

The modules are imported one by one: `q_learning` is light, the others import torch.
"""

"""How random the actions of a soft actor are, which the library does not report."""

from typing import Any

import torch

LAST = 256
"""The mean is taken over this many of the newest observations in the replay buffer."""


def actor_entropy(model: Any) -> float | None:
    """Mean entropy of the actions, squashed into [-1, 1], in nats.

    It is None if the model has no soft actor, or if its replay buffer is empty. It is estimated from one draw per
    observation. The draws do not change the random numbers of the training.
    """
    draw = getattr(getattr(model, "actor", None), "action_log_prob", None)
    buffer = getattr(model, "replay_buffer", None)
    if draw is None or buffer is None or buffer.pos == 0:
        return None
    rows, seen = slice(max(buffer.pos - LAST, 0), buffer.pos), buffer.observations
    newest = {key: _of_all(part[rows]) for key, part in seen.items()} if isinstance(seen, dict) else _of_all(seen[rows])
    with torch.random.fork_rng(devices=[]), torch.no_grad():
        _, log_prob = draw(newest)
    return -float(log_prob.mean())


def _of_all(rows: Any) -> torch.Tensor:
    """Observations (steps, envs, ...) as (steps * envs, ...)."""
    return torch.as_tensor(rows.reshape(-1, *rows.shape[2:]))

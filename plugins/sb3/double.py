"""Double deep Q-learning."""

from typing import Any

import torch
from stable_baselines3 import DQN


class DoubleDQN(DQN):
    """DQN with the target r + gamma Q_target(s', argmax_a Q(s', a)).

    The library's own takes the largest of the target network's values: the network that errs upwards is asked both
    which action is best and how good it is, and the errors add up.
    """

    def _create_aliases(self) -> None:
        super()._create_aliases()
        self.q_net_target = _ChosenByAnother(self.q_net_target, self.q_net)  # type: ignore[assignment]


class _ChosenByAnother(torch.nn.Module):
    """The values of one network, of the actions that another likes best.

    A single value per state, (batch, 1): the largest of it, which the library takes, is the value itself. Parameters
    are those of the first network alone: the library keeps them up to date.
    """

    def __init__(self, valuing: torch.nn.Module, choosing: torch.nn.Module) -> None:
        super().__init__()
        self.valuing = valuing
        self._choosing = (choosing,)  # in a tuple, where torch does not look for parameters

    def forward(self, observations: Any) -> torch.Tensor:
        """(batch, 1)."""
        best = self._choosing[0](observations).argmax(dim=1, keepdim=True)
        values: torch.Tensor = self.valuing(observations)
        return values.gather(1, best)

"""Double deep Q-learning."""

from typing import Any

import torch
from stable_baselines3 import DQN


class DoubleDQN(DQN):
    """DQN with the target r + gamma Q_target(s', argmax_a Q(s', a)).

    The library's own DQN takes the largest value of the target network. That one network then says both which action is
    best and how good it is. So values that are too high are chosen, and these errors add up.
    """

    def _create_aliases(self) -> None:
        super()._create_aliases()
        self.q_net_target = _ChosenByAnother(self.q_net_target, self.q_net)  # type: ignore[assignment]


class _ChosenByAnother(torch.nn.Module):
    """The values that one network gives to the actions which another network likes best.

    There is one value per state, (batch, 1). So the largest value, which the library takes, is this value. Only the
    first network's parameters are parameters of this module. The library keeps them up to date.
    """

    def __init__(self, valuing: torch.nn.Module, choosing: torch.nn.Module) -> None:
        super().__init__()
        self.valuing = valuing
        self._choosing = (choosing,)  # in a tuple, where torch does not look for parameters

    def forward(self, observations: Any) -> torch.Tensor:
        """The values, (batch, 1)."""
        best = self._choosing[0](observations).argmax(dim=1, keepdim=True)
        values: torch.Tensor = self.valuing(observations)
        return values.gather(1, best)

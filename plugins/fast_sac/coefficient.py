"""What a nat of entropy is worth: fixed, or learned."""

import numpy as np

from harness.progress import TrainingState, as_state

from ..soft_actor_critic import SoftActorCritic
from .adam import Adam


class EntropyCoefficient:
    """Learned by its logarithm, so that it stays positive; a fixed one may be 0."""

    def __init__(self, settings: SoftActorCritic, action_size: int) -> None:
        """Begin as the settings say; the entropy aimed at is minus the number of actions."""
        self.value = settings.first_coefficient
        self._learns, self._aim = settings.learns_coefficient, -action_size
        self._logarithm = np.array([np.log(self.value)] if self._learns else [0.0], np.float32)
        self._gradient = np.empty(1, np.float32)
        self._descent = Adam(self._logarithm, self._gradient, settings.learning_rate)

    def state(self) -> TrainingState:
        """All that `restore` needs."""
        return {**self._descent.state(), **as_state({"value": self.value})}

    def restore(self, state: TrainingState) -> None:
        """Be where `state` was told."""
        self._descent.restore(state)
        self.value = float(state["value"])

    def learn(self, entropy: float) -> None:
        """It rises where the entropy of the actions is less than what is aimed at."""
        if self._learns:
            self._gradient[0] = entropy - self._aim
            self._descent.step()
            self.value = float(np.exp(self._logarithm[0]))

"""The entropy coefficient, which says what a nat of entropy is worth. It is fixed or learned."""

import numpy as np

from harness.progress import TrainingState, as_state

from ..soft_actor_critic import SoftActorCritic
from .adam import Adam


class EntropyCoefficient:
    """The entropy coefficient. Its logarithm is learned, so that it stays positive. A fixed one may be 0."""

    def __init__(self, settings: SoftActorCritic, action_size: int) -> None:
        """Begin as the settings say. The target of the entropy is -action_size, in nats."""
        self.value = settings.first_coefficient
        self._learns, self._aim = settings.learns_coefficient, -action_size
        self._logarithm = np.array([np.log(self.value)] if self._learns else [0.0], np.float32)
        self._gradient = np.empty(1, np.float32)
        self._descent = Adam(self._logarithm, self._gradient, settings.learning_rate)

    def state(self) -> TrainingState:
        """Everything that `restore` needs."""
        return {**self._descent.state(), **as_state({"value": self.value})}

    def restore(self, state: TrainingState) -> None:
        """Go on from `state`, which the method of this name returned."""
        self._descent.restore(state)
        self.value = float(state["value"])

    def learn(self, entropy: float) -> None:
        """Learn once, if the coefficient is learned. It rises if `entropy`, in nats, is less than its target."""
        if self._learns:
            self._gradient[0] = entropy - self._aim
            self._descent.step()
            self.value = float(np.exp(self._logarithm[0]))

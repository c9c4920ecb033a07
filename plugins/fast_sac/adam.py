"""Adam on one flat vector."""

import numpy as np

from harness.arrays import Float32
from harness.progress import TrainingState, as_state

BETA_1, BETA_2, EPSILON = 0.9, 0.999, 1e-8


class Adam:
    """Gradient descent with moments (Kingma and Ba 2015), in as few passes over memory as numpy can.

    The moments are kept without their factors 1 - beta, which the step size makes up for.
    """

    def __init__(self, parameters: Float32, gradient: Float32, learning_rate: float) -> None:
        """Begin with `parameters`, (size,). Each step changes them in place by what stands in `gradient`, (size,)."""
        self._parameters, self._gradient, self._learning_rate = parameters, gradient, learning_rate
        self._first, self._second = np.zeros_like(parameters), np.zeros_like(parameters)
        self._room = np.empty_like(parameters)
        self._steps = 0

    def state(self) -> TrainingState:
        """Everything that `restore` needs, the parameters included."""
        return as_state(
            {"parameters": self._parameters, "first": self._first, "second": self._second, "steps": self._steps}
        )

    def restore(self, state: TrainingState) -> None:
        """Go on from `state`, which the method of this name returned."""
        self._parameters[...], self._steps = state["parameters"], int(state["steps"])
        self._first[...], self._second[...] = state["first"], state["second"]

    def step(self) -> None:
        """One step down the gradient."""
        self._steps += 1
        first, second, room = self._first, self._second, self._room
        np.multiply(first, BETA_1, out=first)
        np.add(first, self._gradient, out=first)
        np.multiply(self._gradient, self._gradient, out=room)
        np.multiply(second, BETA_2, out=second)
        np.add(second, room, out=second)
        # first * c1 / (sqrt(second * c2) + epsilon), with one multiplication for both corrections
        correction_1 = (1.0 - BETA_1) / (1.0 - BETA_1**self._steps)
        correction_2 = float(np.sqrt((1.0 - BETA_2) / (1.0 - BETA_2**self._steps)))
        np.sqrt(second, out=room)
        np.add(room, EPSILON / correction_2, out=room)
        np.divide(first, room, out=room)
        np.multiply(room, self._learning_rate * correction_1 / correction_2, out=room)
        np.subtract(self._parameters, room, out=self._parameters)

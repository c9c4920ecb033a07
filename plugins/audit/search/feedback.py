"""Sequences that hold: from some step on, actions draw back to what was observed in that step.

A bare sequence that balances cannot be changed early: whatever follows falls over. One that holds can.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from harness.arrays import Float

from .moves import Moves, Reals, Rng
from .world import Act, Actions


@dataclass(frozen=True, eq=False)
class Feedback:
    """From a step on, an action is linear in how far the observation is from the one of that step.

    Attributes:
        step: From which one on, from 0.
        bias: The action there, in [-1, 1], or how much each choice is liked, (rows,).
        gains: By how much each number of an observation changes that, (rows, size).
    """

    step: int
    bias: Float
    gains: Float

    def after(self, actions: Actions, moves: Moves, flat: Callable[[Any], NDArray[Any]]) -> Act:
        """A policy for one episode: takes the actions of a sequence, (horizon, ...), as the world has them; then holds.

        Args:
            actions: The sequence.
            moves: How actions are written.
            flat: An observation as numbers, (size,).
        """
        taken, held = -1, np.zeros(0)

        def act(observed: Any) -> Any:
            nonlocal taken, held
            taken += 1
            if taken < self.step:
                return actions[taken]
            seen = flat(observed)
            if taken == self.step:
                held = seen
            wanted = self.bias + self.gains @ (seen - held)
            chosen = np.clip(wanted, -1.0, 1.0) if isinstance(moves, Reals) else np.asarray(wanted.argmax())
            return moves.played(chosen)

        return act

    def changed(self, rng: Rng, step: int) -> "Feedback":
        """A little different: begins sooner, later or in another step, is stronger or weaker, has some new numbers."""
        begun = max(0, self.step + int(rng.integers(-4, 5))) if rng.random() < 0.7 else step
        if rng.random() < 0.3:
            return replace(self, step=begun)
        loud = 10.0 ** rng.uniform(-2.0, 0.0)
        near = np.abs(self.gains) + 0.1 * np.abs(self.gains).max(axis=0) * (rng.random(self.gains.shape) < 0.3)
        gains = self.gains * np.exp(rng.normal(0.0, 0.3)) + loud * near * rng.normal(size=self.gains.shape)
        return Feedback(begun, self.bias + 0.3 * loud * rng.normal(size=self.bias.shape), gains)


def draw_feedback(rng: Rng, moves: Moves, spread: Float, step: int) -> Feedback:
    """One that knows nothing: half of its gains are 0.

    Args:
        rng: Draws it.
        moves: What actions there are.
        spread: Of each number of observations, the standard deviation, (size,).
        step: From which one on.
    """
    rows = moves.half.size if isinstance(moves, Reals) else moves.count
    shape = (rows, len(spread))
    gains = rng.choice([-1.0, 1.0], shape) * 10.0 ** rng.uniform(-1.0, 1.0, shape) * (rng.random(shape) < 0.5)
    return Feedback(step, np.zeros(rows), gains / spread)

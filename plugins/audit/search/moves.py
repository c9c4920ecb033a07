"""What actions a world takes, as a search writes them: numbers in [-1, 1], or choices; and how chance moves them.

A bare sequence that balances cannot be changed early, for whatever follows falls over. One that holds by `Feedback`
from some step on can.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, TypeAlias

import gymnasium
import numpy as np
from numpy.typing import NDArray

from harness import Float

from .world import Act, Actions, Rng, Space

WIDEST = 3.0
"""Numbers without bounds are searched up to this one: few environments ask for more."""


@dataclass(frozen=True, eq=False)
class Reals:
    """Actions of a box, each number brought into [-1, 1]; 0 is the middle.

    Attributes:
        middle: Of the box, (size,).
        half: Half its width, (size,).
    """

    middle: Actions
    half: Actions

    def written(self, actions: Actions) -> Actions:
        """The world's actions as the search writes them, (..., size)."""
        return np.asarray(np.clip((actions - self.middle) / self.half, -1.0, 1.0), np.float32)

    def played(self, actions: Actions) -> Actions:
        """The search's actions as the world takes them, (..., size)."""
        return np.asarray(self.middle + self.half * actions, np.float32)

    def chosen(self, wanted: Float) -> Actions:
        """The action that numbers ask for, (size,)."""
        return np.clip(wanted, -1.0, 1.0)

    def white(self, rng: Rng, count: int, steps: int) -> Actions:
        """Actions drawn one by one, (count, steps, size)."""
        return rng.uniform(-1.0, 1.0, (count, steps, self.half.size)).astype(np.float32)

    def coloured(self, rng: Rng, count: int, steps: int) -> Actions:
        """Episodes of noise of many colours, (count, steps, size).

        Each number keeps its value for a while: one step, the whole episode or anything between. A third of the
        episodes goes from one extreme to the other, a third glides from value to value, and some are small.
        """
        size, rows = self.half.size, np.arange(count)[:, None, None]
        spells = _spells(rng, (count, 1, size), steps)
        clock = np.arange(steps)[:, None] / spells + rng.uniform(0.0, 1.0, (count, 1, size))
        place = clock.astype(np.int64)
        knots = rng.uniform(-1.0, 1.0, (count, steps + 2, size))
        kind, column = rng.integers(3, size=(count, 1, 1)), np.arange(size)
        knots = np.where(kind == 0, np.sign(knots), knots)
        here, there = knots[rows, place, column], knots[rows, place + 1, column]
        along = np.where(kind == 1, clock - place, 0.0)
        loud = np.where(rng.random((count, 1, 1)) < 0.3, 10.0 ** rng.uniform(-1.5, 0.0, (count, 1, 1)), 1.0)
        return (((1.0 - along) * here + along * there) * loud).astype(np.float32)

    def resting(self, rng: Rng, count: int) -> Actions:
        """What may keep still: nothing, (count, 1, size)."""
        return np.zeros((count, 1, self.half.size), np.float32)

    def turned(self, actions: Actions) -> Actions:
        """The way back."""
        return -actions


@dataclass(frozen=True)
class Choices:
    """Actions that are one of a few.

    Attributes:
        count: How many there are.
        first: The smallest.
    """

    count: int
    first: int = 0

    def written(self, actions: Actions) -> Actions:
        """The world's actions as the search writes them, from 0."""
        return np.asarray(actions, np.int64) - self.first

    def played(self, actions: Actions) -> Actions:
        """The search's actions as the world takes them."""
        return actions + self.first

    def chosen(self, wanted: Float) -> Actions:
        """The choice that is liked most, one number for each; of two, one number may tell which."""
        return np.asarray(wanted.argmax() if len(wanted) == self.count else wanted[0] > 0.0, np.int64)

    def white(self, rng: Rng, count: int, steps: int) -> Actions:
        """Actions drawn one by one, (count, steps)."""
        return rng.integers(self.count, size=(count, steps))

    def coloured(self, rng: Rng, count: int, steps: int) -> Actions:
        """Episodes that keep a choice for a while, from one step to all of them, and like some choices more."""
        clock = np.arange(steps) / _spells(rng, (count, 1), steps) + rng.uniform(0.0, 1.0, (count, 1))
        liked = np.cumsum(rng.dirichlet(np.full(self.count, 0.7), count), axis=1)
        knots = (rng.random((count, steps + 1, 1)) > liked[:, None, :-1]).sum(axis=2)
        return np.take_along_axis(knots, clock.astype(np.int64), axis=1)

    def resting(self, rng: Rng, count: int) -> Actions:
        """What may keep still: any one choice, (count, 1)."""
        return rng.integers(self.count, size=(count, 1))

    def turned(self, actions: Actions) -> Actions:
        """The way back, where choices are in an order: left and right, push and pull."""
        return self.count - 1 - actions


Moves: TypeAlias = Reals | Choices


def bounds_of(space: gymnasium.spaces.Box) -> tuple[Float, Float]:
    """The numbers of an action are searched between these, (size,); where nothing bounds one, `WIDEST` does."""
    low, high = space.low.astype(np.float64).ravel(), space.high.astype(np.float64).ravel()
    return (
        np.where(np.isfinite(low), low, np.minimum(high, 0.0) - WIDEST),
        np.where(np.isfinite(high), high, np.maximum(low, 0.0) + WIDEST),
    )


def moves_in(space: Space) -> Moves:
    """How a search writes the actions of a space."""
    if isinstance(space, gymnasium.spaces.Discrete):
        return Choices(int(space.n), int(space.start))
    low, high = bounds_of(space)
    return Reals((low + high) / 2.0, np.maximum((high - low) / 2.0, 1e-9))


def _spells(rng: Rng, shape: tuple[int, ...], steps: int) -> Actions:
    """For how many steps a value is kept, from 1 to `steps`, each magnitude as likely."""
    return np.exp(rng.uniform(0.0, np.log(max(steps, 2)), shape))


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
            return moves.played(moves.chosen(self.bias + self.gains @ (seen - held)))

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

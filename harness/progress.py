"""What a training tells while it runs."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from harness.policy import Policy


@dataclass(frozen=True, eq=False)
class Ring:
    """Rows that are kept until others take their places, as in a replay buffer.

    Of a ring a checkpoint writes what is new since the last checkpoint alone, however much it holds.

    Attributes:
        columns: Arrays by name, (capacity, ...) each. The row that was written as number i, counted from 0 on, stands
            at place i % capacity. In a ring that is restored the places that were never written are left out.
        written: How many rows were ever written.
    """

    columns: Mapping[str, NDArray[Any]]
    written: int

    def copy_into(self, columns: Mapping[str, NDArray[Any]]) -> None:
        """Put the rows of a ring that is restored to their places in `columns`, (capacity, ...) each."""
        for name, rows in self.columns.items():
            columns[name][: len(rows)] = rows


TrainingState: TypeAlias = Mapping[str, Any]
"""Everything that a training needs to go on, by name: numpy arrays of numbers, of any shape, and every `Ring`."""


SUCCESS, RETURN, SPEED = "Training/Success Rate", "Training/Episode Return", "Training/Steps per Second"
"""What the harness itself tells of every training: the share of the last `LAST_EPISODES` episodes that reached the
target, and what they were paid on average; environment steps per second since the last word."""
LAST_EPISODES = 100

TOLD_EVERY = 100
SCALARS_EVERY = 1000
"""Environment steps from one word about progress, or about scalars, to the next: how often the built-in ones tell."""


class Progress:
    """Told how a training goes. This one does nothing with it: each method may be replaced.

    An algorithm has to call it, ``progress(steps)``, now and then and at the end. All else makes it more useful:
    a learning curve, scalars for trackers, checkpoints.
    """

    def __call__(self, steps: int) -> None:
        """`steps` environment steps are done, counted over all envs."""

    def policy(self, steps: int, make: "Callable[[], Policy]") -> None:
        """`make` would give the policy as it is after `steps`; it is called only when an evaluation is due."""

    def scalars(self, steps: int, values: Mapping[str, float]) -> None:
        """Numbers to watch, such as ``Losses/Policy Loss``, as they are after `steps`."""

    def checkpoint(self, steps: int, make: Callable[[], TrainingState]) -> None:
        """Offer a place to go on from, should the process be killed later.

        Call it between two steps of the env, as often as you like: `make` is called only when a checkpoint is due, and
        most of the time none is. What is due depends on the clock: making a checkpoint must change nothing, so `make`
        draws no random numbers and touches nothing that the training uses.

        `make` gives all that your algorithm would need in a new process to go on from here as if nothing had
        happened: weights, those of target networks too; what the optimisers remember; random generators; counters and
        schedules; the observation that the next action is for; rewards and observations that you have gathered and not
        yet learned from. Give numbers and arrays of numbers, made with `as_state`. A replay buffer is a `Ring`.
        The env's own state is kept by the harness, episodes under way included: leave it out, and when your training is
        `restored`, do not reset the env but act on the observation that you kept.

        Arrays are read before this method returns, so they need not be copies.

        Args:
            steps: Environment steps that are done, counted over all envs.
            make: See above.
        """

    def restored(self) -> TrainingState | None:
        """What the last checkpoint holds, if this training goes on from one; ask once, before the first step.

        By the same names, arrays as they were given. `env.environment_steps` stands where it stood then.
        """
        return None


def as_state(values: Mapping[str, Any]) -> TrainingState:
    """Numbers, arrays and rings as a state."""
    return {name: value if isinstance(value, Ring) else np.asarray(value) for name, value in values.items()}


def under(prefix: str, state: TrainingState) -> TrainingState:
    """The part of a state whose names begin with `prefix`, without it."""
    return {name.removeprefix(prefix): value for name, value in state.items() if name.startswith(prefix)}


def prefixed(prefix: str, state: TrainingState) -> TrainingState:
    """A state as part of a larger one: `under` gives it back."""
    return {f"{prefix}{name}": value for name, value in state.items()}

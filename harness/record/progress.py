"""What a training reports while it runs."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from harness.policy import Policy


@dataclass(frozen=True, eq=False)
class Ring:
    """Rows that are kept until newer rows replace them, as in a replay buffer.

    A checkpoint writes only the rows of a ring that are new since the last checkpoint, however many the ring holds.

    Attributes:
        columns: Arrays by name, (capacity, ...) each. Rows are counted from 0 on; row i stands at place i % capacity.
            In a restored ring, places that were never written are left out.
        written: How many rows were written in all, replaced ones included.
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
"""What the harness itself reports of every training: the share of the last `LAST_EPISODES` episodes that reached the
target, what these episodes were paid on average, and environment steps per second since the last report."""
TERMS = "Reward Terms"
"""The first part of the names of what the terms of the reward paid these episodes on average."""
LAST_EPISODES = 100


class Progress:
    """An algorithm reports to this object how its training goes. This base class ignores the reports.

    An algorithm has to call ``progress(steps)`` now and then and at the end. The other methods are optional. They give
    a learning curve, scalars for trackers, and checkpoints.
    """

    def __call__(self, steps: int) -> None:
        """`steps` environment steps are done, counted over all envs."""

    def policy(self, steps: int, make: "Callable[[], Policy]") -> None:
        """Offer the policy as it is after `steps`. `make` returns it, and is called only if an evaluation is due."""

    def scalars(self, steps: int, values: Mapping[str, float]) -> None:
        """Numbers to watch, such as ``Losses/Policy Loss``, as they are after `steps`."""

    def checkpoint(self, steps: int, make: Callable[[], TrainingState]) -> None:
        """Offer a state from which the training can go on if the process is killed later.

        Call it between two steps of the env, as often as you like. `make` is called only if a checkpoint is due, which
        is seldom. When one is due depends on the clock. So making a checkpoint must not change the training: `make`
        draws no random numbers and changes nothing that the training uses.

        `make` returns everything that your algorithm needs in a new process to go on from here as if nothing had
        happened: all weights, with those of target networks; the state of the optimisers; random generators; counters
        and schedules; the observation that the next action is for; rewards and observations that you have gathered and
        not yet learned from. Return numbers and arrays of numbers, made with `as_state`. A replay buffer is a `Ring`.
        Leave out the env's own state, because the harness keeps it, with the episodes that have not ended. When your
        training is `restored`, do not reset the env, but act on the observation that you saved.

        Arrays are read before this method returns, so they need not be copies.

        Args:
            steps: Environment steps that are done, counted over all envs.
            make: Returns the state, see above.
        """

    def restored(self) -> TrainingState | None:
        """The state in the last checkpoint if this training goes on from one, else None.

        Call it once, before the first step. Names and arrays are those that you gave. `env.environment_steps` has the
        value that it had then.
        """
        return None


def as_state(values: Mapping[str, Any]) -> TrainingState:
    """Numbers, arrays and rings as a state.

    A mapping in it, such as the state of a network, becomes part of it: ``under("network.", state)`` gives it back.
    """
    state: dict[str, Any] = {}
    for name, value in values.items():
        if isinstance(value, Mapping):
            state |= prefixed(f"{name}.", as_state(value))
        else:
            state[name] = value if isinstance(value, Ring) else np.asarray(value)
    return state


def under(prefix: str, state: TrainingState) -> TrainingState:
    """The part of a state whose names begin with `prefix`, without it; the arrays are the same ones.

    Args:
        prefix: The name that `as_state` was given for a state within, and a dot.
        state: What `Progress.restored` returns, or a part of it.
    """
    return {name.removeprefix(prefix): value for name, value in state.items() if name.startswith(prefix)}


def prefixed(prefix: str, state: TrainingState) -> TrainingState:
    """A state as part of a larger one: `under` gives it back."""
    return {f"{prefix}{name}": value for name, value in state.items()}

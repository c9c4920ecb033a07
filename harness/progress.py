"""What a training tells while it runs."""

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from harness.policy import Policy

TrainingState: TypeAlias = Mapping[str, NDArray[Any]]
"""Everything that a training needs to go on, by name; numbers are arrays of shape ()."""


TOLD_EVERY = 100
SCALARS_EVERY = 1000
"""Environment steps from one word about progress, or about scalars, to the next: how often the built-in ones tell."""


class Progress:
    """Told how a training goes. This one does nothing with it: each method may be replaced.

    An algorithm has to call it, ``progress(steps)``, now and then and at the end. All else makes it more useful:
    a learning curve, scalars for TensorBoard, checkpoints.
    """

    def __call__(self, steps: int) -> None:
        """`steps` environment steps are done, counted over all envs."""

    def policy(self, steps: int, make: "Callable[[], Policy]") -> None:
        """`make` would give the policy as it is after `steps`; it is called only when an evaluation is due."""

    def scalars(self, steps: int, values: Mapping[str, float]) -> None:
        """Numbers to watch, such as ``Losses/Policy Loss``, as they are after `steps`."""

    def checkpoint(self, steps: int, make: Callable[[], TrainingState]) -> None:
        """`make` would give all that is needed to go on after `steps`; it is called only when a checkpoint is due.

        Call it where the next thing done to the env is to reset all of it: of episodes under way nothing is kept. A
        training that is `restored` begins with that reset.
        """

    def restored(self) -> TrainingState | None:
        """What the last checkpoint holds, if this training goes on from one; ask once, before the first step."""
        return None


def as_state(values: Mapping[str, Any]) -> TrainingState:
    """Numbers and arrays as a state."""
    return {name: np.asarray(value) for name, value in values.items()}

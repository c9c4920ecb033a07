"""What a cell trains in: an arm in a simulator, or an environment of anybody."""

import time
from abc import ABC, abstractmethod
from collections import deque
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, closing, contextmanager, nullcontext
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

from harness.algorithm import Algorithm, TrainingEnv
from harness.arrays import Float
from harness.executor import NO_SCALARS
from harness.experiment.checkpoints.checkpoint import Attempt
from harness.experiment.provenance import describe_environment
from harness.experiment.workers.order import TELL_EVERY, Beat, Report
from harness.log.log import OpenEpisodes
from harness.policy import Policy
from harness.record.cell import Cell
from harness.record.progress import LAST_EPISODES, RETURN, SPEED, SUCCESS, TrainingState
from harness.registry.choice import Registry

if TYPE_CHECKING:
    from harness.eta.manner import Acted
    from harness.experiment.trials.tried import Tried
    from harness.registry.choice import Choice
    from harness.robot import Robot


class Batch(TrainingEnv, Protocol):
    """Envs that a checkpoint can keep."""

    def state(self) -> TrainingState | None:
        """Everything that `restore` needs, between two steps; None if it is not known."""

    def restore(self, state: TrainingState) -> None:
        """Go on from the state that envs of the same kind returned.

        Raises:
            SchemaError: They cannot be brought there.
        """

    def close(self) -> None:
        """Close all envs."""


class LastEpisodes:
    """Knows what the last `LAST_EPISODES` episodes of a training came to.

    Its steps are added up when somebody asks, or when there are `BLOCK` of them.
    """

    BLOCK = 4096

    def __init__(self, *others: str) -> None:
        """Start before any episode has ended.

        Args:
            others: The names of what is added up beside pay and success.
        """
        self._names, self._waiting, self._count = (RETURN, SUCCESS, *others), list[Any](), 0
        self._open = OpenEpisodes.none(1 + len(self._names))
        self._ended: deque[Float] = deque(maxlen=LAST_EPISODES)

    def take(self, steps: Any) -> None:
        """Take steps, (steps, numbers), of which nobody changes anything later; `_columns` says what they are."""
        self._waiting.append(steps)
        self._count += len(steps)
        if self._count >= self.BLOCK:
            self._add_up()

    def means(self) -> dict[str, float]:
        """Means of what is known of these episodes, by name; empty before one has ended."""
        self._add_up()
        told = ((name, of[~np.isnan(of)]) for name, of in zip(self._names, np.array(self._ended).T, strict=False))
        return {name: float(of.mean()) for name, of in told if len(of)}

    def _columns(self, steps: Float) -> Sequence[Float]:
        """Env, episode and whether it ends; whether its first step is seen; pay, success and what else is added up."""
        return [*steps.T]

    def _add_up(self) -> None:
        if not self._waiting:
            return
        env, episode, ends, *summed = self._columns(np.concatenate(self._waiting))
        self._waiting, self._count = [], 0
        self._open, _, (is_whole, paid, success, *others) = self._open.after(env, episode, ends, summed)
        self._ended.extend(np.array([paid, np.minimum(success, 1.0), *others]).T[is_whole > 0])


class CellWorld(ABC):
    """Where one cell trains, and where its policies are evaluated.

    It is built once. The training env stands where `restore` left it, or at its beginning.

    Attributes:
        suffix: What the names of recorded evaluations end with: ``.parquet``, or nothing if they are folders.
    """

    suffix = ""
    _robot: "Robot | None" = None

    def __init__(self, cell: Cell, registry: Registry, folder: Path, report: Report) -> None:
        """Make nothing yet; see `world_of`."""
        self._cell, self._registry, self._folder = cell, registry, folder
        self._report, self._beat = report, Beat(report)
        self._algorithm: Algorithm
        self._batch: Batch | None = None
        self._told, self._steps = time.monotonic(), 0

    @cached_property
    def runs_on(self) -> Mapping[str, Any]:
        """Versions, machine and sources; see `harness.experiment.provenance.describe_environment`."""
        return describe_environment(self._cell, self._robot, self._registry)

    @abstractmethod
    def build(self, algorithm: Algorithm) -> Mapping[str, Any]:
        """Build what the cell names, for an algorithm that trains on so many envs.

        Returns:
            Fields of the manifest that are known before the training begins.
        """

    def restore(self, state: TrainingState) -> None:
        """Bring the training env to the state of a checkpoint.

        Raises:
            SchemaError: It cannot be brought there.
        """
        batch, self._batch = self._batch or self._open(), None
        try:
            batch.restore(state)
        except BaseException:
            batch.close()
            raise
        self._batch = batch

    @contextmanager
    def training(self, attempt: Attempt) -> Iterator[TrainingEnv]:
        """The training env. It records every step until the block ends."""
        batch = self._batch = self._batch or self._open()
        self._told, self._steps = time.monotonic(), attempt.begun_from
        with closing(batch), self._recorded(attempt):
            yield batch

    def learned(self, steps: int, *, if_due: bool = False) -> Mapping[str, float]:
        """What the last episodes came to, by name; nothing between two times to tell it."""
        now = time.monotonic()
        if steps == self._steps or (if_due and now < self._told + TELL_EVERY):
            return NO_SCALARS
        speed = {SPEED: (steps - self._steps) / (now - self._told)} if now > self._told else {}
        self._told, self._steps = now, steps
        return {**speed, **self._last_episodes()}

    def kept(self) -> tuple[TrainingState, int] | None:
        """For a checkpoint: the state of the training env, and how many rows were recorded before.

        None if it cannot be kept.
        """
        state = self._batch.state() if self._batch else None
        return None if state is None else (state, self._keep())

    @abstractmethod
    def evaluate(
        self, policy: Policy, acted: "Acted", episodes: int, path: Path, *, after: int = 0, seed: int | None = None
    ) -> None:
        """Record episodes of a policy; it needs no `build`.

        Args:
            policy: The policy that acts.
            acted: ``"deterministic"`` if it takes the one action of each observation, ``"stochastic"`` if it draws, and
                ``"random"`` if it is the floor that policies are held against.
            episodes: How many.
            path: Where the recording is written; nothing is there.
            after: Environment steps of training before it; 0 if the training has ended.
            seed: Of the starts and targets; None for those of every evaluation. Others choose among policies.
        """

    @abstractmethod
    def try_out(self, rewards: "Sequence[Choice]", without: Collection[str], tell: Callable[[str], None]) -> "Tried":
        """Ask rewards and measures, and whatever else is recorded, in an episode of random actions.

        Args:
            rewards: Those of an arm that are tried; in an environment all are.
            without: Of the rewards and measures, named as columns are: these are not asked.
            tell: Told which is asked next.
        """

    @abstractmethod
    def scalars(self, path: Path) -> dict[str, float]:
        """What a recorded evaluation came to, by the names that trackers show."""

    @abstractmethod
    def finish(self, folder: Path) -> Sequence[str]:
        """Leave what else belongs to a cell, and say what there is to know of it, a line each."""

    @abstractmethod
    def _open(self) -> Batch:
        """The envs of a training."""

    @abstractmethod
    def _last_episodes(self) -> Mapping[str, float]:
        """What the last episodes of the training came to."""

    def _recorded(self, attempt: Attempt) -> AbstractContextManager[object]:
        """Record what the opened envs do until the block ends, where they do not do so themselves."""
        return nullcontext()

    def _keep(self) -> int:
        """Have what was recorded so far on the disk; returns how many rows, 0 where they are recorded anew."""
        return 0

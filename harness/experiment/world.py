"""The interface of what a cell trains in: an arm in a simulator, or an environment of anybody."""

from collections.abc import Callable, Collection, Mapping, Sequence
from contextlib import AbstractContextManager
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

from harness.algorithm import Algorithm, TrainingEnv
from harness.experiment.checkpoints.checkpoint import Attempt
from harness.experiment.workers.order import Report
from harness.policy import Policy
from harness.progress import TrainingState
from harness.record.cell import Cell
from harness.registry.registry import Registry

if TYPE_CHECKING:
    from harness.eta.manner import Acted
    from harness.experiment.trials.tried import Tried
    from harness.registry.choice import Choice


class CellWorld(Protocol):
    """Where one cell trains, and where its policies are evaluated.

    It is built once. The training env stands where `restore` left it, or at its beginning.
    """

    @property
    def suffix(self) -> str:
        """What the names of recorded evaluations end with: ``.parquet``, or nothing if they are folders."""

    @property
    def runs_on(self) -> Mapping[str, Any]:
        """Versions, machine and sources; see `harness.experiment.provenance.describe_environment`."""

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

    def training(self, attempt: Attempt) -> AbstractContextManager[TrainingEnv]:
        """The training env. It records every step until the block ends."""

    def learned(self, steps: int, *, if_due: bool = False) -> Mapping[str, float]:
        """What the last episodes came to, by the names of `harness.progress`; nothing between two times to tell it."""

    def kept(self) -> tuple[TrainingState, int] | None:
        """For a checkpoint: the state of the training env, and how many rows were recorded that it does not tell.

        None if it cannot be kept.
        """

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

    def try_out(self, rewards: "Sequence[Choice]", without: Collection[str], tell: Callable[[str], None]) -> "Tried":
        """Ask rewards and measures, and whatever else is recorded, in an episode of random actions.

        Args:
            rewards: Those of an arm that are tried; in an environment all are.
            without: Of the rewards and measures, named as columns are: these are not asked.
            tell: Told which is asked next.
        """

    def scalars(self, path: Path) -> dict[str, float]:
        """What a recorded evaluation came to, by the names that trackers show."""

    def finish(self, folder: Path) -> Sequence[str]:
        """Leave what else belongs to a cell, and say what there is to know of it, a line each."""


def world_of(cell: Cell, registry: Registry, folder: Path, report: Report) -> CellWorld:
    """The world of a cell. It imports what such a cell needs, and no more.

    Args:
        cell: The cell.
        registry: The plugins.
        folder: Where its recordings are written.
        report: Told that something goes on.
    """
    if cell.is_in_environment:
        from harness.experiment.environments.world import EnvironmentWorld

        return EnvironmentWorld(cell, registry, folder, report)
    from harness.experiment.arm_world import ArmWorld

    return ArmWorld(cell, registry, report)

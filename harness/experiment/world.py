"""The interface of what a cell trains in: an arm in a simulator, or an environment of anybody."""

from collections.abc import Mapping, Sequence
from contextlib import AbstractContextManager
from pathlib import Path
from typing import Any, Protocol

from harness.algorithm import Algorithm, TrainingEnv
from harness.experiment.checkpoints.attempt import Attempt
from harness.experiment.watch import Watch
from harness.experiment.workers.order import Report
from harness.policy import Policy
from harness.progress import TrainingState
from harness.record.cell import Cell
from harness.registry.registry import Registry


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

    def build(self, algorithm: Algorithm) -> None:
        """Build what the cell names, for an algorithm that trains on so many envs."""

    def restore(self, state: TrainingState) -> None:
        """Bring the training env to the state of a checkpoint.

        Raises:
            SchemaError: It cannot be brought there.
        """

    def training(self, attempt: Attempt) -> AbstractContextManager[TrainingEnv]:
        """The training env. It records every step until the block ends."""

    def facts(self) -> Mapping[str, Any]:
        """Fields of the manifest that are known when the training begins."""

    def learned(self, steps: int, *, if_due: bool = False) -> Mapping[str, float]:
        """What the last episodes came to, by the names of `harness.progress`; nothing between two times to tell it."""

    def kept(self) -> tuple[TrainingState, Sequence[str]] | None:
        """For a checkpoint: the state of the training env, and digests of what was recorded before.

        None if it cannot be kept.
        """

    def record(self, policy: Policy, deterministic: bool, path: Path, after: int) -> None:
        """Record an evaluation.

        Args:
            policy: The policy that acts.
            deterministic: Whether it takes the one action of each observation, or draws.
            path: Where the recording is written; nothing is there.
            after: Environment steps of training before it; 0 if the training has ended.
        """

    def record_random(self, policy: Policy, path: Path) -> None:
        """Record random actions: what policies of this kind are held against."""

    def validate(self, policy: Policy, episodes: int, path: Path, seed: int) -> None:
        """Record episodes that no evaluation has, to choose among policies by them.

        Args:
            policy: The policy that acts, without drawing.
            episodes: How many.
            path: Where the recording is written.
            seed: Of the starts and targets.
        """

    def scalars(self, path: Path) -> dict[str, float]:
        """What a recorded evaluation came to, by the names that trackers show."""

    def finish(self, folder: Path) -> Sequence[str]:
        """Leave what else belongs to a cell, and say what there is to know of it, a line each."""


def world_of(cell: Cell, registry: Registry, folder: Path, report: Report, watch: Watch) -> CellWorld:
    """The world of a cell. It imports what such a cell needs, and no more.

    Args:
        cell: The cell.
        registry: The plugins.
        folder: Where its recordings are written.
        report: Told that something goes on.
        watch: Looks on.
    """
    if cell.is_in_environment:
        from harness.experiment.environments.world import EnvironmentWorld

        return EnvironmentWorld(cell, registry, folder, report)
    from harness.experiment.arm_world import ArmWorld

    return ArmWorld(cell, registry, report, watch)

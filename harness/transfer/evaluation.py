"""Evaluate one cell's policy in another simulator: the cell's own evaluation, the simulator apart."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, ClassVar, Self

from harness.env.make import build_world
from harness.experiment.arm_evaluation import record_evaluation
from harness.experiment.draft import draft_of
from harness.experiment.provenance import describe_environment
from harness.experiment.workers.order import Report
from harness.policy import load_policy
from harness.record.folder import EVALUATION, POLICY
from harness.record.manifest import read_manifest
from harness.registry.choice import Choice
from harness.registry.given import Given, given_from_json, given_to_json
from harness.registry.registry import load_registry
from harness.robot.load import load_robot
from harness.transfer.record import TransferRecord, policy_digest

KINDS = ("simulators", "tasks", "rewards")
"""What makes the result; the library that trained the policy is not needed, and need not be there."""


def evaluate_elsewhere(
    cell_folder: Path, simulator: Choice, folder: Path, plugins: Sequence[Given] = ()
) -> TransferRecord:
    """Let the policy of a done cell do the cell's evaluation episodes in `simulator`.

    The folder is written beside its final name and renamed when complete. What a plugin raises ends up in the record,
    as the reason of a failed evaluation, and in the log.

    Args:
        cell_folder: Of the cell that trained the policy.
        simulator: Where to evaluate it.
        folder: To leave; replaced if it exists.
        plugins: Given by hand.
    """
    trained = read_manifest(cell_folder).cell
    record = TransferRecord(trained.id, simulator, policy_digest(cell_folder), status="done")
    with draft_of(folder, record) as draft:
        registry, cell = load_registry(given=plugins), replace(trained, simulator=simulator)
        robot = load_robot(cell.robot, registry)
        draft.note(environment=describe_environment(cell, robot, registry, KINDS))
        world, policy = build_world(cell, robot, registry), load_policy(cell_folder / POLICY)
        record_evaluation(world, policy, cell.acted, cell.evaluation_episodes, draft.partial / EVALUATION)
    return draft.record


@dataclass(frozen=True)
class EvaluateElsewhere:
    """`evaluate_elsewhere`, as a worker is told to do it.

    Attributes:
        cell_folder: Of the cell that trained the policy.
        simulator: Where to evaluate it.
        plugins: Given by hand.
    """

    cell_folder: Path
    simulator: Choice
    plugins: tuple[Given, ...] = ()

    noun: ClassVar[str] = "evaluation"

    def to_json(self) -> dict[str, Any]:
        """See `harness.experiment.workers.order.Work`."""
        told = {"cell_folder": str(self.cell_folder), "simulator": self.simulator.to_json()}
        return {**told, "plugins": given_to_json(self.plugins)}

    @classmethod
    def from_json(cls, data: Mapping[str, Any]) -> Self:
        """See `harness.experiment.workers.order.Work`."""
        plugins = given_from_json(data["plugins"])
        return cls(Path(data["cell_folder"]), Choice.from_json(data["simulator"]), plugins)

    def do(self, folder: Path, report: Report) -> bool:
        """See `harness.experiment.workers.order.Work`."""
        return evaluate_elsewhere(self.cell_folder, self.simulator, folder, self.plugins).status == "done"

"""Validation: episodes that policies of a search are judged by.

Their starts and targets are drawn from another seed than those of the evaluation after a training
(`harness.experiment.arm_evaluation`). So no comparison that follows uses the episodes that chose the settings.
"""

import shutil
import traceback
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar, Self

from harness.errors import one_line
from harness.experiment.watch import UNWATCHED
from harness.experiment.workers.order import Order, Report
from harness.experiment.workers.workers import News, run_orders
from harness.experiment.world import world_of
from harness.policy import Policy, load_policy
from harness.record.cell import Cell
from harness.record.folder import EVALUATION, POLICY, partial_folder, publish, recording_of
from harness.record.manifest import read_manifest
from harness.registry.given import Given, given_from_json, given_to_json
from harness.registry.registry import Registry, load_registry

VALIDATION_SEED = 20_230_705
"""Seed of the starts and targets of every validation. It is not the evaluation's, and not a small number."""
REASON = "reason.txt"
"""The file in the folder of a failed validation that says why there is no trace."""


@dataclass(frozen=True)
class ValidatePolicy:
    """One policy to validate, as a worker is told to do it.

    It leaves a folder with the recording of these episodes, or with the `REASON` why there is none.

    Attributes:
        cell_folder: Of the done cell that trained it.
        episodes: How many.
        plugins: Given by hand.
    """

    cell_folder: Path
    episodes: int
    plugins: tuple[Given, ...] = ()

    noun: ClassVar[str] = "validation"

    def to_json(self) -> dict[str, Any]:
        """See `harness.experiment.workers.order.Work`."""
        told = {"cell_folder": str(self.cell_folder), "episodes": self.episodes}
        return {**told, "plugins": given_to_json(self.plugins)}

    @classmethod
    def from_json(cls, data: Mapping[str, Any]) -> Self:
        """See `harness.experiment.workers.order.Work`."""
        return cls(Path(data["cell_folder"]), data["episodes"], given_from_json(data["plugins"]))

    def do(self, folder: Path, report: Report) -> bool:
        """See `harness.experiment.workers.order.Work`; a plugin may raise anything."""
        partial = partial_folder(folder)
        partial.mkdir(parents=True, exist_ok=True)
        try:
            cell, policy = read_manifest(self.cell_folder).cell, load_policy(self.cell_folder / POLICY)
            registry = load_registry(given=self.plugins)
            record_validation(cell, registry, policy, self.episodes, partial, report)
        except (Exception, SystemExit) as error:
            traceback.print_exc()
            _leave_reason(folder, one_line(error))
            return False
        publish(partial, folder)
        return True


def validate_all(orders: Sequence[Order], at_once: int) -> None:
    """Have policies validated, in processes of their own: an engine that crashes costs one policy alone.

    Args:
        orders: Each a `ValidatePolicy`. Those whose folder is there are not done again; each of the others then has its
            folder.
        at_once: How many processes.
    """

    def hear(news: News) -> None:
        if news.kind == "ended" and news.reason:
            _leave_reason(news.folder, news.reason)

    run_orders([order for order in orders if not order.folder.exists()], at_once, hear)


def record_validation(
    cell: Cell, registry: Registry, policy: Policy, episodes: int, folder: Path, report: Report
) -> None:
    """Let `policy` do `episodes` episodes where the cell was trained, and record them in `folder`."""
    world = world_of(cell, registry, folder, report, UNWATCHED)
    path = folder / f"{recording_of(EVALUATION)}{world.suffix}"
    world.evaluate(policy, "deterministic", episodes, path, seed=VALIDATION_SEED)


def _leave_reason(folder: Path, reason: str) -> None:
    partial = partial_folder(folder)
    (partial / EVALUATION).unlink(missing_ok=True)
    shutil.rmtree(partial / recording_of(EVALUATION), ignore_errors=True)
    (partial / REASON).write_text(reason)
    publish(partial, folder)

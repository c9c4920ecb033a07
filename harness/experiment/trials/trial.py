"""The trial of a task, done in a process that a reward may end, crash or keep busy."""

import faulthandler
import json
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import ClassVar

from harness.errors import HarnessError, one_line
from harness.executor import Limits
from harness.experiment.trials.tried import Fault, Tried, fault_of
from harness.experiment.workers.offspring import Offspring
from harness.experiment.workers.order import Order, Report
from harness.experiment.workers.workers import News, Pool
from harness.experiment.world import world_of
from harness.files.plain import Plain
from harness.record.cell import Cell
from harness.record.folder import LOG, partial_folder, publish
from harness.registry.choice import Choice
from harness.registry.given import Given
from harness.registry.registry import load_registry

CALL_SECONDS, ENV_SECONDS, ALL_SECONDS = 10.0, 120.0, 300.0
"""How long one call of a reward, what an env does by itself, and a whole trial may take."""
LIMITS = Limits(cell_time=ALL_SECONDS)
MOST_LOST = 5
"""After so many processes that did not survive a reward, no other is started."""
ANSWER, TIMEOUT = "tried.json", "Timeout ("
"""The file with the answer, and what begins the stack that `faulthandler` writes when a call takes too long."""


@dataclass(frozen=True)
class TryTask(Plain):
    """The trial of one task, as a worker is told to do it.

    Attributes:
        cell: Whose task, or environment.
        rewards: Those of an arm that are tried; in an environment all are.
        plugins: What was given by hand.
        notes: Path of a file that names the column that is asked.
        without: Columns that are not asked.
    """

    cell: Cell
    rewards: tuple[Choice, ...]
    plugins: tuple[Given, ...]
    notes: str = ""
    without: tuple[str, ...] = ()

    noun: ClassVar[str] = "trial"

    def do(self, folder: Path, report: Report) -> bool:
        with Path(self.notes).open("wb", buffering=0) as notes:

            def tell(column: str) -> None:
                notes.seek(0)
                notes.write(column.encode() + b"\n")
                faulthandler.dump_traceback_later(CALL_SECONDS if column else ENV_SECONDS, exit=True)

            try:
                world = world_of(self.cell, load_registry(given=self.plugins), folder, report)
                tried = world.try_out(self.rewards, self.without, tell)
            except HarnessError as error:
                tried = Tried((), (one_line(error),))
            finally:
                faulthandler.cancel_dump_traceback_later()
        (partial_folder(folder) / ANSWER).write_text(json.dumps(tried.to_json()), encoding="utf-8")
        publish(partial_folder(folder), folder, is_lasting=False)
        return True


def try_tasks(works: Sequence[TryTask]) -> list[Tried]:
    """The trials of tasks, one after the other. When it returns, none of their processes and files are left."""
    offspring = Offspring()
    with (
        tempfile.TemporaryDirectory(prefix="harness-trial-", ignore_cleanup_errors=True) as folder,
        Pool(offspring.environment) as pool,
        offspring.ended_at_once(),
    ):
        return [_try(work, Path(folder) / str(number), pool, offspring) for number, work in enumerate(works)]


def _try(work: TryTask, folder: Path, pool: Pool, offspring: Offspring) -> Tried:
    """One trial; without each reward that a process did not survive, it is begun again."""
    lost: list[Fault] = []
    notes = folder.with_suffix(".notes")
    for number in range(1 + MOST_LOST):
        answer = folder.with_name(f"{folder.name}-{number}")
        without = tuple(fault.column for fault in lost)
        *_, news = pool.run([Order(answer, replace(work, notes=str(notes), without=without), LIMITS)], at_once=1)
        if not news.reason:
            tried = Tried.from_json(json.loads((answer / ANSWER).read_text(encoding="utf-8")))
            return replace(tried, faults=(*lost, *tried.faults))
        offspring.kill()
        reason = _why_lost(news, partial_folder(answer) / LOG)
        column = notes.read_text(encoding="utf-8").partition("\n")[0] if notes.exists() else ""
        if not column:
            return Tried(tuple(lost), (f"{work.cell.task.label}: its trial failed, {reason}",))
        lost.append(fault_of(column, reason, is_lost=True))
    return Tried(tuple(lost))


def _why_lost(news: News, log: Path) -> str:
    text = log.read_text(encoding="utf-8", errors="replace") if log.is_file() else ""
    if TIMEOUT in text or news.over_limit:
        return f"has not returned after {CALL_SECONDS:g} s."
    return f"ends the process: {news.reason}."

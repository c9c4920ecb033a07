"""One round of one entry, in a process of its own."""

import json
import shutil
import warnings
from collections.abc import Mapping
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar, Self

from harness.authoring.commands import (
    Given,
    News,
    Order,
    Report,
    given_from_json,
    given_to_json,
    load_registry,
    partial_folder,
    publish,
    run_orders,
)
from harness.errors import UsageError, one_line

from .contest import Round, round_of, take_turns
from .contests import open_contest
from .entry import Entry, Setting
from .timed_cell import Failed

FILE = "turns.json"


class LeftOut(Failed):
    """Why an entry cannot be timed here: nothing is wrong with it."""


@dataclass(frozen=True)
class TimeContest:
    """What a worker is told to do: let the contenders of an entry take turns.

    Attributes:
        entry: What is timed.
        setting: What all entries have in common.
        plugins: Given by hand.
    """

    entry: Entry
    setting: Setting
    plugins: tuple[Given, ...] = ()

    noun: ClassVar[str] = "timing"

    def to_json(self) -> dict[str, Any]:
        """See `harness.experiment.workers.order.Work`."""
        told = {"entry": self.entry.to_json(), "setting": self.setting.to_json()}
        return {**told, "plugins": given_to_json(self.plugins)}

    @classmethod
    def from_json(cls, data: Mapping[str, Any]) -> Self:
        """See `harness.experiment.workers.order.Work`."""
        plugins = given_from_json(data["plugins"])
        return cls(Entry.from_json(data["entry"]), Setting.from_json(data["setting"]), plugins)

    def do(self, folder: Path, report: Report) -> bool:
        """See `harness.experiment.workers.order.Work`."""
        partial = partial_folder(folder)
        (partial / FILE).write_text(json.dumps(self.turns()))
        publish(partial, folder)
        return False

    def turns(self) -> dict[str, Any]:
        """What was measured, or why nothing was; a plugin may raise anything."""
        try:
            with ExitStack() as stack, warnings.catch_warnings():
                warnings.simplefilter("ignore")  # those of other people's environments
                registry = load_registry(given=self.plugins)
                contenders, reference = open_contest(self.entry, self.setting, registry, stack)
                return {"reference": reference, "turns": take_turns(contenders, self.setting.budget)}
        except UsageError as error:
            return {"left out": str(error)}
        except Exception as error:
            return {"failed": one_line(error)}


def time_contest(work: TimeContest, folder: Path) -> Round | Failed:
    """Have a fresh one-thread process do one round of an entry.

    Args:
        work: What to do.
        folder: Where; removed again.
    """
    ended: list[str] = []

    def tell(news: News) -> None:
        if news.kind == "ended":
            ended.append(news.reason)

    run_orders([Order(folder, work, fresh=True)], 1, tell)
    [reason] = ended
    if reason:
        return Failed(reason)
    told = json.loads((folder / FILE).read_text())
    shutil.rmtree(folder)
    if "left out" in told:
        return LeftOut(told["left out"])
    return Failed(told["failed"]) if "failed" in told else round_of(told["turns"], told["reference"])

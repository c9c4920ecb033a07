"""Every entry, several rounds, each in a process of its own."""

import json
import platform
import shutil
import warnings
from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import asdict, dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, ClassVar, Self

from harness.algorithm import learns, needs_goals
from harness.authoring.commands import (
    Given,
    News,
    Order,
    Registry,
    Report,
    choose,
    describe_machine,
    given_from_json,
    given_to_json,
    load_registry,
    parse,
    partial_folder,
    publish,
    run_orders,
    split_list,
    versions_behind,
)
from harness.errors import UsageError, one_line

from .contests import Entry, Kind, Round, Setting, open_contest, round_of, take_turns
from .speeds import Reason, Speed, Speeds
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
        return {
            "entry": asdict(self.entry),
            "setting": asdict(self.setting),
            "plugins": given_to_json(self.plugins),
        }

    @classmethod
    def from_json(cls, data: Mapping[str, Any]) -> Self:
        return cls(Entry(**data["entry"]), Setting(**data["setting"]), given_from_json(data["plugins"]))

    def do(self, folder: Path, report: Report) -> bool:
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


NO_GOALS = "it pays steps again for other goals, and is timed on a task of an arm, which does not allow that"
SIZES = (1, 64, 1024)
"""Envs that a simulator is timed with."""
OnRound = Callable[[int, int, str], None]
"""Told before each: its number, how many there are, and the entry's title."""


def plan_entries(
    registry: Registry, kinds: Sequence[Kind], sim: Sequence[str], algo: Sequence[str], sizes: Sequence[int]
) -> tuple[list[Entry], list[Reason]]:
    """What is to be timed.

    Args:
        registry: The plugins.
        kinds: Which tables are wanted.
        sim: Simulators, as a user names them; none for all that are installed.
        algo: Algorithms, likewise.
        sizes: Numbers of envs of a simulator.

    Returns:
        The entries, and what is left out: titles with reasons.

    Raises:
        UsageError: A name or a parameter is not known, or something that was named is not installed.
    """
    entries: list[Entry] = []
    left_out: list[Reason] = []
    if {"simulators", "peers"} & set(kinds):
        simulators = _chosen(registry, "simulators", sim, left_out)
    if {"algorithms", "peers"} & set(kinds):
        algorithms = _chosen(registry, "algorithms", algo, left_out)
    if "simulators" in kinds:
        entries += [Entry("simulators", "simulators", name, size) for name in simulators for size in sizes]
    if "algorithms" in kinds:
        goalless = {name: it for name, it in algorithms.items() if not needs_goals(it)}
        left_out += [Reason(name, NO_GOALS) for name in algorithms.keys() - goalless.keys()]
        entries += [Entry("algorithms", "algorithms", name) for name, it in goalless.items() if learns(it)]
    if "peers" in kinds:
        entries += [
            Entry("peers", "simulators", name, peer=peer)
            for name, it in simulators.items()
            for peer in getattr(it, "peer_envs", dict)()
        ]
        entries += [
            Entry("peers", "algorithms", name, peer=peer)
            for name, it in algorithms.items()
            for peer in getattr(it, "peer_trainings", dict)()
        ]
    return entries, list(dict.fromkeys(left_out))


def _chosen(registry: Registry, kind: str, given: Sequence[str], left_out: list[Reason]) -> dict[str, Any]:
    """By label what was named, or else all; of these, those that cannot be loaded are left out."""
    found: dict[str, Any] = {}
    for name in split_list(given) or registry.names(kind):
        try:
            choice = choose(registry, kind, name)
        except Exception as error:
            if given:
                raise
            left_out.append(Reason(name, str(error)))
        else:
            found[choice.label] = choice.build(registry, kind)
    return found


def measure_speeds(
    registry: Registry,
    entries: Sequence[Entry],
    left_out: Sequence[Reason],
    setting: Setting,
    rounds: int,
    on_round: OnRound,
) -> Speeds:
    """Time every entry, in a fresh process each round.

    The entries take turns. One that fails, or cannot be timed here, is not tried again.

    Args:
        registry: The plugins.
        entries: What to time.
        left_out: What was left out before; it is told with the rest.
        setting: What all entries have in common.
        rounds: How often, >= 1.
        on_round: Told what goes on.
    """
    found: dict[Entry, list[Round]] = {entry: [] for entry in entries}
    ended: dict[Entry, Failed] = {}
    with TemporaryDirectory(prefix="harness-bench-") as folder:
        for number in range(rounds):
            for place, entry in enumerate(entries):
                if entry in ended:
                    continue
                on_round(number * len(entries) + place + 1, rounds * len(entries), entry.title)
                times = time_contest(TimeContest(entry, setting, registry.given), Path(folder) / "timing")
                if isinstance(times, Failed):
                    ended[entry] = times
                else:
                    found[entry].append(times)
    specs = [registry.get(entry.of, parse(entry.name)[0]) for entry in entries]
    reasons = {entry.title: why for entry, why in ended.items()}
    impossible = [Reason(title, why.reason) for title, why in reasons.items() if isinstance(why, LeftOut)]
    return Speeds(
        rounds=rounds,
        setting=setting,
        speeds=tuple(Speed(entry, tuple(found[entry])) for entry in entries if entry not in ended),
        failed=tuple(Reason(title, why.reason) for title, why in reasons.items() if not isinstance(why, LeftOut)),
        left_out=(*left_out, *impossible),
        cpu=describe_machine()["cpu"],
        versions={"python": platform.python_version(), **versions_behind(specs)},
    )

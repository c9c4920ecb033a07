"""The results in an experiment's folder: combinations, cells, behaviour, how it stands. Reads results only."""

import html
import importlib.util
from abc import ABC, abstractmethod
from collections import Counter
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any, ClassVar

import pyarrow as pa

from harness.arrays import Float
from harness.errors import UsageError
from harness.eta.curve import Kind
from harness.eta.equal import Key, equal_trainings, key_to_json
from harness.eta.index import Estimate
from harness.eta.laws import Account, counted, is_left_out
from harness.eta.verdict.looks import LookRuling
from harness.files.plain import Plain, tells, to_plain
from harness.log import Log
from harness.log.measure import Measure
from harness.record.cell import Cell, Manifest
from harness.record.folder import TRACE, begun_by
from harness.record.plan_file import StoredPlan
from harness.record.store import Store
from harness.record.terms import Terms
from harness.registry.choice import Registry
from harness.registry.given import plugin_flags
from harness.results.choosing import Choosing
from harness.results.compare import UNKNOWN, compare_all
from harness.results.comparison import Comparison, Group, Seen, pools_of
from harness.results.frames import Frames
from harness.results.learning import Learning
from harness.results.logs.told import FOUND_OUT, Told
from harness.results.metrics import Measured, Moment, Values, measure, named_measures
from harness.results.overview import overview_html
from harness.results.pool import Pool
from harness.results.recordings.runs import Runs
from harness.results.table import Numbers, cell_to_json, comparison_rows, metric_columns, table_of, write_table
from harness.results.trainings import Alone, Match, TermsPaid, Trained, Trainings, alone_of, terms_of


@tells("*group", "returns", "events", "manner")
@dataclass(frozen=True)
class ReturnMatrix(Plain):
    """Returns of the final evaluations with one simulator, robot, task and algorithm.

    Attributes:
        group: What the trainings share.
        trained_with: Labels of the rewards that the policies were trained with.
        returns: Shaped return of an episode, mean over episodes and seeds: by the label of the scoring reward, then
            that of the training reward.
        events: What the events of an episode paid on top, the same under every reward, by training reward; empty if
            there are none.
        manner: Where the episodes are taken from; empty for the final evaluation.
    """

    group: Group
    trained_with: tuple[str, ...]
    returns: Mapping[str, Mapping[str, Estimate]]
    events: Mapping[str, Estimate]
    manner: str = ""


FORMAT = 2
"""The version of what reports say as JSON; docs/json.md explains it."""
LEFT_SOMETHING = ("done", "failed", "damaged")
"""How cells end that were begun."""


class Results(ABC):
    """The cells of an experiment, or recorded trainings, and what compares them.

    Attributes:
        subject: What behaves, in words.
        in_environment: Whether it is no arm.
    """

    subject: ClassVar[str]
    in_environment: ClassVar[bool]

    def __init__(
        self,
        folder: Path,
        registry: Registry,
        plan: StoredPlan,
        kind: Kind = "accumulated",
        *,
        metrics: Iterable[str] | str | None = None,
        is_temporary: bool = False,
        pairs: bool = False,
        told: Told = FOUND_OUT,
        loose: Runs | None = None,
    ) -> None:
        """Read all manifests.

        Args:
            folder: The folder of the experiment, or of recordings.
            registry: The plugins, for metrics and rewards.
            plan: What was asked for.
            kind: Which curves the indices are read from; see `harness.eta.curve.GroupCurve`.
            metrics: Which metrics; every registered one if None, see `harness.results.metrics.load_metrics`. Of an
                environment: which of its measures, beside the one that decides.
            is_temporary: Whether the folder is soon gone, so that no command may name it.
            pairs: Whether every two rewards are compared, and not each with the baseline alone.
            told: What the user says: which cells of an experiment are left out, and how bad and good measures can be.
            loose: Recordings or logs that no experiment made.

        Raises:
            UsageError: A named metric is not registered, or what is to be left out is no cell that ended.
            PluginError: A named metric is broken.
            SchemaError: A newer version wrote a file in it.
        """
        self.folder, self.registry, self.plan, self.store = folder, registry, plan, Store(folder)
        self.kind: Kind = kind
        self.loose = loose
        self.is_temporary, self.pairs, self._chosen = is_temporary, pairs, metrics
        self.baseline, self.named = plan.baseline, named_measures(plan.experiment)
        self.manifests = list(map(self._examine, plan.cells))
        if plan.terms.race:  # who left it was trained no further
            why = "the race that was run here ended without it"
            self.manifests = [
                replace(it, status="not needed", reason=why) if it.status == "pending" else it for it in self.manifests
            ]
        self.account, self._told = self._counted(told.leave_out), told

    # What trained

    @property
    @abstractmethod
    def metrics(self) -> Mapping[str, Measure]:
        """Every registered metric, or those that were chosen, by name; none of an environment."""

    @property
    @abstractmethod
    def trainings(self) -> Sequence[Trainings]:
        """Those that are done, by group, as far as there is something to compare."""

    @property
    def _asked(self) -> Sequence[tuple[Trainings, Match]]:
        """What is compared: each reward that taught with the baseline, or every two; the null control too."""
        return [(it, match) for it in self.trainings for match in it.matches(pairs=self.pairs)]

    @abstractmethod
    def _matrices(self) -> Iterator[ReturnMatrix]:
        """See `returns`."""

    def _lines(self) -> Iterable[str]:
        """What to keep in mind of the trainings that were read."""
        return ()

    @abstractmethod
    def run(self, cell: Cell) -> Trained | None:
        """A done cell as a training; None of one in an environment that is not compared, and so was not read."""

    @abstractmethod
    def numbers(self, cell: Cell) -> Numbers:
        """The numbers of a done cell, in the columns of `write_table`."""

    @abstractmethod
    def recorded(self, cell: Cell) -> Float:
        """What a done cell's own reward paid, every row of its training, (rows,)."""

    def _examine(self, cell: Cell) -> Manifest:
        """What there is to say of a cell; of one that is not done, what it has recorded so far."""
        found = self.store.examine(cell)
        if found.status != "pending":
            return found
        from harness.results.under_way import so_far  # SciPy is loaded where a training goes on alone

        told = so_far(cell, self.store)
        return replace(found, reason=f"{cell.title}: {told.text}") if told else found

    # The cells

    @property
    def is_experiment(self) -> bool:
        """Whether an experiment made what is read, so that it can be repeated."""
        return self.loose is None

    def _counted(self, leave_out: Collection[Path]) -> Account[Manifest]:
        """The account of all cells that ended; those that the user leaves out are skipped from here on."""
        ended = {self.store.cell_folder(it.cell): it for it in self.manifests if it.status in LEFT_SOMETHING}
        named = [next((folder for folder in ended if is_left_out(path, [folder])), path) for path in leave_out]
        account = counted([(it, folder, it.reason) for folder, it in ended.items()], named)
        out = {
            ended[it.path].cell: f"left out, as --leave-out says{': ' * bool(it.why)}{it.why}"
            for it in account.left_out
        }
        self.manifests = [
            replace(it, status="skipped", reason=out[it.cell]) if it.cell in out else it for it in self.manifests
        ]
        return account

    @property
    def failed(self) -> list[Manifest]:
        """Cells that failed."""
        return [manifest for manifest in self.manifests if manifest.status == "failed"]

    @property
    def damaged(self) -> list[Manifest]:
        """Cells with a file that is not what was written. Nothing is read of them."""
        return [manifest for manifest in self.manifests if manifest.status == "damaged"]

    @property
    def experiment_text(self) -> str:
        """The newest experiment as an experiment file."""
        return self.plan.experiment_text

    @property
    def plugin_flags(self) -> str:
        """The flags that give the plugins of the newest experiment, to be appended to ``harness run``; often empty."""
        return plugin_flags(self.plan.experiment.get("plugins"))

    @property
    def report_flags(self) -> str:
        """Those of them that a report needs."""
        return plugin_flags(self.plan.experiment.get("plugins"), for_report=True)

    @property
    def done(self) -> list[Manifest]:
        """Cells that left a trace."""
        return [manifest for manifest in self.manifests if manifest.status == "done"]

    @cached_property
    def groups(self) -> dict[Group, list[Cell]]:
        """Cells that left a trace, by the group in which they are compared."""
        groups: dict[Group, list[Cell]] = {}
        for group, cell in self._grouped(self.done):
            groups.setdefault(group, []).append(cell)
        return groups

    def _grouped(self, manifests: Iterable[Manifest]) -> list[tuple[Group, Cell]]:
        """Cells, each with the group in which it is compared."""
        return [(Group.of(it.cell), it.cell) for it in manifests]

    @cached_property
    def equal(self) -> dict[Group, tuple[tuple[Key, ...], ...]]:
        """Trainings of an arm that left the same trace, bit for bit, by their group."""

        def parts(cell: Cell) -> str:
            digests = self.manifest(cell).files.items()
            return " ".join(digest for name, digest in digests if TRACE in (name, begun_by(name)))

        traces = {
            group: {(cell.reward.label, cell.seed): parts(cell) for cell in cells}
            for group, cells in self.groups.items()
        }
        return {group: equal for group, of in traces.items() if (equal := equal_trainings(of))}

    @property
    def done_cells(self) -> list[Cell]:
        """The same, without the cells that only the null control needs."""
        return [manifest.cell for manifest in self.done if not self.is_control(manifest.cell)]

    def is_control(self, cell: Cell) -> bool:
        """Whether only the null control needs a cell: the baseline trained again with another seed."""
        control = self.plan.control
        return cell.reward.label == self.baseline and cell.seed in control.values() and cell.seed not in control

    def manifest(self, cell: Cell) -> Manifest:
        """The manifest of a planned cell."""
        return self._ended[cell.id]

    @cached_property
    def _ended(self) -> dict[str, Manifest]:
        return {manifest.cell.id: manifest for manifest in self.manifests}

    # What is compared

    @property
    def measures(self) -> tuple[str, ...]:
        """The names of all measures of behaviour."""
        return tuple(dict.fromkeys([*self.metrics, *(name for it in self.trainings for name in it.names)]))

    @property
    def not_measured(self) -> dict[str, str]:
        """Why each metric failed in a done cell, from the first such cell."""
        reasons: dict[str, str] = {}
        for manifest in self.done:
            reasons = {**self.measured(manifest.cell).reasons, **reasons}
        return reasons

    @cached_property
    def combinations(self) -> tuple[Comparison, ...]:
        """Every proposed reward against the baseline, or every two rewards where `pairs` was asked for.

        A baseline that is its own proposed reward is the null control; these come last.
        """
        unread = UNKNOWN if self.plan.note else sum(len(it.missing) for it in self._read)
        asked, manifests = self._asked, self.manifests
        if self.choosing is not None:
            asked, manifests = self.choosing.compared(asked), self.choosing.fresh
        return compare_all(asked, self.plan.terms, manifests, unread, self._told)

    @cached_property
    def choosing(self) -> Choosing | None:
        """How `harness choose` stands; None of another experiment."""
        return (
            Choosing(self.plan.terms, self.baseline, self.manifests, self.trainings) if self.plan.terms.budget else None
        )

    @property
    def _read(self) -> list[Runs]:
        """What was read of recordings and logs."""
        return [it.read for it in self.trainings if it.read]

    @property
    def pools(self) -> tuple[Pool, ...]:
        """One answer for each reward over all places in which it trained, where there are several."""
        return pools_of(self.combinations)

    @cached_property
    def notes(self) -> tuple[str, ...]:
        """What to keep in mind of the trainings, a line each; a plan of looks waits for no cell that failed."""
        is_told = self.account.missing and not self.plan.terms.looks and not self.is_temporary
        return (*self._lines(), *([self.account.remedy] if is_told else ()))

    @property
    def said(self) -> tuple[str, ...]:
        """How what was found was sorted and read, a line each: what to know before the first number."""
        return tuple(line for it in self._read for line in it.said)

    @property
    def damaged_recordings(self) -> tuple[str, ...]:
        """Recordings that could not be read, a line each; a cell with a damaged file is among `damaged` instead."""
        return tuple(dict.fromkeys(line for it in self._read for line in it.damaged))

    @cached_property
    def returns(self) -> tuple[ReturnMatrix, ...]:
        """What each reward would have paid the policies that each reward trained.

        Raises:
            SchemaError: A file is damaged or written by a newer version.
        """
        return tuple(self._matrices())

    @cached_property
    def terms(self) -> tuple[TermsPaid, ...]:
        """What each term of each reward paid, of the rewards that have terms.

        Raises:
            SchemaError: A file is damaged or written by a newer version.
        """
        return tuple(paid for trainings in self.trainings for paid in terms_of(trainings))

    @cached_property
    def alone(self) -> tuple[Alone, ...]:
        """What each reward paid for that no other stands beside, so that nothing compares it.

        Raises:
            SchemaError: A file is damaged or written by a newer version.
        """
        return tuple(alone for it in self.trainings if (alone := alone_of(it)) is not None)

    def learning(self, comparison: Comparison) -> Learning | None:
        """How the policies of a comparison behaved while they learned; None if that is not known.

        Of all trainings of each reward. None for the null control, and where one has none.

        Raises:
            SchemaError: A file is damaged or written by a newer version.
        """
        if comparison.is_control or not comparison.has_trainings:
            return None
        return next((it.learning(comparison) for it in self.trainings if it.group == comparison.group), None)

    def measured(self, cell: Cell) -> Measured:
        """Every measure of a done cell, by manner; none of a cell in an environment that is not compared."""
        run = self.run(cell)
        return run.measured if run else Measured({}, {}, {})

    def moments(self, cell: Cell) -> tuple[Moment, ...]:
        """Every evaluation of a done cell during its training, and the one after it."""
        run = self.run(cell)
        return tuple(run.moments) if run else ()

    def frames(self, cell: Cell, episode: int = 0) -> Frames | None:
        """Pictures of an evaluation episode that an environment drew; None of an arm, which has a replay."""
        return None

    def measure(self, trace: Log) -> Values:
        """Every metric of an evaluation."""
        return measure(self.metrics, trace)

    def to_json(self) -> dict[str, Any]:
        """Combinations and cells, plain data; see `harness.report.document` for all that a report says."""
        told: dict[str, Any] = to_plain({
            "format": FORMAT,
            "baseline": self.baseline,
            "curve": self.kind,
            "combinations": self.combinations,
            "over_places": self.pools,
            "terms": self.plan.terms,
            "recovered": self.plan.note,
            "cells": [{**cell_to_json(it), "task": it.cell.task.label} for it in self.manifests],
            "not_measured": self.not_measured,
            "equal_trainings": [
                {**to_plain(group), "trainings": [key_to_json(key) for key in keys]}
                for group, equal in self.equal.items()
                for keys in equal
            ],
        })  # fmt: skip
        return told

    def write_table(self) -> Path:
        """Write ``results.parquet``, one row per cell: every metric of its policy and of random actions.

        In an environment: what the policy did in its evaluation (``behaviour_success``), and what every reward paid for
        it (``return_own``), means over episodes.
        """
        return write_table(self.folder, self._rows(), metric_columns(self.metrics))

    def to_pandas(self) -> Any:
        """The table of `write_table` as a `pandas.DataFrame`, one row per cell.

        Raises:
            UsageError: pandas is not installed.
        """
        return _data_frame(table_of(self._rows(), metric_columns(self.metrics)), "to_pandas")

    def comparisons(self) -> Any:
        """A `pandas.DataFrame` with a row per comparison: the answer, its test, what decides, and the numbers.

        `harness.results.table.comparison_rows` makes the same as a table of pyarrow, which needs no pandas.

        Raises:
            UsageError: pandas is not installed.
        """
        return _data_frame(comparison_rows(self.combinations), "comparisons")

    def __repr__(self) -> str:
        counts = Counter(manifest.status for manifest in self.manifests)
        ended = ", ".join(f"{count} {status}" for status, count in counts.items())
        return f"<Results of '{self.folder}': {len(self.manifests)} cells ({ended})>"

    def _repr_html_(self) -> str:
        """What a notebook shows: a line per comparison."""
        return overview_html(self.combinations) + f"<p>{html.escape(repr(self))}</p>"

    def _rows(self) -> list[tuple[Manifest, Numbers | None]]:
        return [(it, self.numbers(it.cell) if it.status == "done" else None) for it in self.manifests]


def _data_frame(table: pa.Table, asked: str) -> Any:
    if importlib.util.find_spec("pandas") is None:
        raise UsageError(f"{asked} needs pandas: pip install pandas")
    return table.to_pandas()


@tells("looks=terms.looks", "next_look", "open", "most_trainings_left=most_left")
@dataclass(frozen=True, eq=False)
class Standing(Plain):
    """How an experiment with looks stands.

    Attributes:
        terms: What was agreed on before the first training.
        rewards: All rewards, the baseline first.
        open: Those that are trained further; the baseline is among them as long as any other is.
        seen: The trainings.
        unanswered: Rewards that used all looks, and have no answer.
    """

    terms: Terms
    rewards: tuple[str, ...]
    open: tuple[str, ...]
    seen: Seen
    unanswered: tuple[str, ...] = ()

    @property
    def is_over(self) -> bool:
        """Whether nothing more is to be trained."""
        return not self.open

    @property
    def look(self) -> int:
        """The look that comes next, counted from 0."""
        return min((self.seen.complete(reward) for reward in self.open), default=len(self.terms.looks))

    @property
    def next_look(self) -> int:
        """The same, counted from 1."""
        return self.look + 1

    @property
    def next(self) -> list[Cell]:
        """The cells of the next look, and of those before it, that an answer waits for."""
        return [] if self.is_over else self.seen.cells_of(self.open, min(self.look, len(self.terms.looks) - 1))

    @property
    def most_left(self) -> int:
        """How many trainings there can be at most until everything is over."""
        return len(self._pending) - len(self.not_needed)

    @cached_property
    def not_needed(self) -> frozenset[Cell]:
        """The pending cells that no answer waits for."""
        return self._pending.difference(self.seen.cells_of(self.open, len(self.terms.looks) - 1))

    @cached_property
    def _pending(self) -> frozenset[Cell]:
        statuses = self.seen.status.values()
        return frozenset(cell for cells in statuses for cell, status in cells.items() if status == "pending")

    @property
    def text(self) -> str:
        """How it stands, in a line."""
        left = "" if self.is_over else f", at most {self.most_left} trainings left"
        others = len(self.rewards) - 1
        decided = others - len(self.open[1:]) - len(self.unanswered)
        unanswered = f", {len(self.unanswered)} without an answer (all looks are used)" if self.unanswered else ""
        return f"{decided} of {others} decided{unanswered}{left}"


def standing_of(results: Results) -> Standing | Choosing | None:
    """How the experiment in a folder stands; None if its seeds were not planned to the end."""
    terms = results.plan.terms
    if results.choosing is not None:
        return results.choosing
    if not terms.looks:
        return None
    seen = Seen.of(results.manifests, terms.looks)
    rewards = tuple(sorted(dict.fromkeys(it for _, it in seen.status), key=lambda it: it != results.baseline))
    ruled = {it.proposed: (it.answer.pool or it.answer).ruling for it in results.combinations}
    over = {name: it for name, it in ruled.items() if isinstance(it, LookRuling) and it.is_over}
    left = [reward for reward in rewards[1:] if reward not in over]
    unanswered = tuple(name for name, it in over.items() if not it.is_decided and it.small is None)
    return Standing(terms, rewards, (rewards[0], *left) if left else (), seen, unanswered=unanswered)


def standing_to_json(standing: Standing | Choosing | None) -> dict[str, Any]:
    """Plain data: what reports and `harness status` say."""
    told = standing and standing.to_json()
    return {"looks": None, "choosing": told} if isinstance(standing, Choosing) else {"looks": told, "choosing": None}


def told_manifests(results: Results) -> list[Manifest]:
    """How each cell ended, in the order of the plan. Pending ones that no answer waits for are *not needed*."""
    standing = standing_of(results)
    if standing is None:
        return results.manifests
    spared = standing.not_needed
    return [
        replace(it, status="not needed", reason="the answer stands without it") if it.cell in spared else it
        for it in results.manifests
    ]

"""Success and return of policies trained in one simulator and evaluated in another. Reads results only."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar, NamedTuple, TypeAlias

from harness.eta import SHARE, Estimate, mean_over_seeds
from harness.eta.headline import SUCCESS
from harness.files.plain import Plain, tells
from harness.record import EVALUATION, Cell, read_trace
from harness.record.trace import mean_return
from harness.registry import Choice
from harness.results import Group, Results, Shown

from .record import TRANSFER, TransferRecord, policy_digest, read_record_of, read_transfer, simulator_id

FORMAT = 2

Pair: TypeAlias = tuple[Choice, Choice]
"""Trained in, evaluated in."""
Grid: TypeAlias = tuple[tuple[Estimate, ...], ...]
"""A row per simulator trained in, a column per simulator evaluated in."""


class Evaluation(NamedTuple):
    """What the policy of one seed did in one simulator."""

    success: float | None
    """Share of the episodes that reach the target; None where the metric is not installed."""
    paid: float | None
    """Mean over the episodes of all that was paid in one; None without a finished episode."""


@tells(
    "*group.labels",
    "steps=group.steps",
    "evaluation_episodes=group.evaluation_episodes",
    "deterministic=group.deterministic",
    "trained_in",
    "evaluated_in",
    "success",
    "return=paid",
    "drop",
)
@dataclass(frozen=True)
class TransferMatrix(Plain):
    """Policies of one algorithm and reward, by the simulators that they were trained and evaluated in.

    Attributes:
        group: What the policies share.
        trained_in: Labels of simulators, one per row.
        evaluated_in: The same, one per column.
        success: Share of the episodes that reach the target, mean over seeds.
        paid: Return: shaped reward and event terms of an episode, mean over episodes and seeds.
        drop: Success where trained minus success here, the same seeds in both; no mean where that is the same place.
    """

    group: Group
    trained_in: tuple[str, ...]
    evaluated_in: tuple[str, ...]
    success: Grid
    paid: Grid
    drop: Grid


@tells(
    "cell=cell.id",
    "algorithm=cell.algorithm.label",
    "reward=cell.reward.label",
    "seed=cell.seed",
    "trained_in=cell.simulator.label",
    "evaluated_in=record.simulator.label",
    "reason=record.reason",
)
class Failure(NamedTuple):
    """One evaluation that failed."""

    cell: Cell
    record: TransferRecord


@tells("format", "combinations=matrices", "failed")
@dataclass(frozen=True)
class Transfers(Plain):
    """Everything that an experiment's folder says of transfer."""

    matrices: tuple[TransferMatrix, ...]
    failed: tuple[Failure, ...]

    format = FORMAT


def load_transfers(results: Results) -> Transfers:
    """One matrix per algorithm and reward; none where no policy was evaluated away from where it was trained.

    Raises:
        SchemaError: A file is damaged or written by a newer version; damaged transfers are told under `failed`.
    """
    every = {cell: _records(results, cell) for cell in results.done_cells}
    records = {cell: [record for record in found if record.status != "damaged"] for cell, found in every.items()}
    groups: dict[Group, list[Cell]] = {}
    for cell in records:
        groups.setdefault(Group.of(cell, compared="simulator"), []).append(cell)
    matrices = [
        _matrix(results, group, {cell: records[cell] for cell in cells})
        for group, cells in groups.items()
        if any(records[cell] for cell in cells)
    ]
    failed = [Failure(cell, record) for cell, found in every.items() for record in found if record.status != "done"]
    return Transfers(tuple(matrices), tuple(failed))


def _records(results: Results, cell: Cell) -> list[TransferRecord]:
    """The records of the cell's policy as it is now, by simulator."""
    folders = sorted((results.folder / TRANSFER / cell.id).glob("[!.]*"))
    if not folders:
        return []
    digest = policy_digest(results.store.cell_folder(cell))
    found = [read_transfer(folder) for folder in folders]
    return [record for record in found if record is not None and record.is_of(digest)]


def _matrix(results: Results, group: Group, records: Mapping[Cell, list[TransferRecord]]) -> TransferMatrix:
    trained_in = tuple(dict.fromkeys(cell.simulator for cell in records))
    visited = sorted((record.simulator for found in records.values() for record in found), key=lambda it: it.label)
    evaluated_in = tuple(dict.fromkeys([*trained_in, *visited]))
    table = _Table(results, records)
    return TransferMatrix(
        group,
        tuple(it.label for it in trained_in),
        tuple(it.label for it in evaluated_in),
        *(
            tuple(tuple(mean(home, place) for place in evaluated_in) for home in trained_in)
            for mean in (table.success, table.paid, table.drop)
        ),
    )


class _Table:
    """The evaluations of one group, by simulators and seed."""

    def __init__(self, results: Results, records: Mapping[Cell, list[TransferRecord]]) -> None:
        self._seeds: dict[Choice, list[int]] = {}
        self._known: dict[Pair, dict[int, Evaluation]] = {}
        self._failed: dict[Pair, int] = {}
        for cell, found in sorted(records.items(), key=lambda item: item[0].seed):
            home = cell.simulator
            self._seeds.setdefault(home, []).append(cell.seed)
            self._known.setdefault((home, home), {})[cell.seed] = _evaluation(results, cell, None)
            for record in found:
                pair = (home, record.simulator)
                if record.status == "done":
                    self._known.setdefault(pair, {})[cell.seed] = _evaluation(results, cell, record)
                else:
                    self._failed[pair] = self._failed.get(pair, 0) + 1

    def success(self, home: Choice, place: Choice) -> Estimate:
        values = [it.success for it in self._evaluations(home, place).values() if it.success is not None]
        return mean_over_seeds(values, self._missing(home, place, len(values)), SHARE)

    def paid(self, home: Choice, place: Choice) -> Estimate:
        values = [it.paid for it in self._evaluations(home, place).values() if it.paid is not None]
        return mean_over_seeds(values, self._missing(home, place, len(values)))

    def drop(self, home: Choice, place: Choice) -> Estimate:
        if home == place:
            return Estimate(None, notes=("evaluated where it was trained",))
        trained = self._known[home, home]
        lost = [
            there - here.success
            for seed, here in self._evaluations(home, place).items()
            if (there := trained[seed].success) is not None and here.success is not None
        ]
        return mean_over_seeds(lost, self._missing(home, place, len(lost)), (-1.0, 1.0))

    def _evaluations(self, home: Choice, place: Choice) -> Mapping[int, Evaluation]:
        """By seed, those that were evaluated."""
        return self._known.get((home, place), {})

    def _missing(self, home: Choice, place: Choice, defined: int) -> str | None:
        """How many seeds have no evaluation, and why; or that it says nothing for some; None if all have a value."""
        told = self._unevaluated(home, place)
        return told or (None if defined == len(self._evaluations(home, place)) else "not defined for every seed")

    def _unevaluated(self, home: Choice, place: Choice) -> str | None:
        count, failed = len(self._seeds[home]), self._failed.get((home, place), 0)
        waiting = count - failed - len(self._evaluations(home, place))
        told = {"failed": failed, "not evaluated": waiting}
        return ", ".join(f"{number} of {count} {what}" for what, number in told.items() if number) or None


def _evaluation(results: Results, cell: Cell, record: TransferRecord | None) -> Evaluation:
    """The evaluation of a policy where it was trained, or where the record says."""
    if record is None:
        folder = results.store.cell_folder(cell)
    else:
        folder = results.folder / TRANSFER / cell.id / simulator_id(record.simulator)
    trace = read_trace(folder / EVALUATION)
    return Evaluation(results.measure(trace).get(SUCCESS), mean_return(trace))


@dataclass(frozen=True)
class TransferSection:
    """A matrix of every algorithm and reward: trained in one simulator, evaluated in another."""

    what: ClassVar[str] = "an evaluation elsewhere"

    def ending(self, folder: Path) -> TransferRecord:
        return read_record_of(folder)

    def show(self, results: Results) -> Shown | None:
        from .shown import transfer_facts

        transfers = load_transfers(results)
        return Shown(transfer_facts(transfers), transfers.to_json()) if transfers.matrices else None

"""Compares two groups of recorded runs: their indices, eta_N, eta_P, and how much of each is only a change of ruler."""

import hashlib
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import zip_longest
from typing import Any, NamedTuple

import numpy as np

from harness.arrays import Float, Mask
from harness.errors import UsageError
from harness.eta import (
    BB,
    BK,
    KB,
    KK,
    GroupCurve,
    Names,
    corrected_p,
    decompose,
    number_sentence,
)
from harness.eta.curve import Kind
from harness.eta.laws import counted, shortfall_beside
from harness.eta.splits import Decomposition, Pair
from harness.files.plain import Plain, tells
from harness.log import Log, Rows
from harness.log.log import ROWS, is_countable
from harness.registry.choice import Registry, choose
from harness.reward import Reward
from harness.reward.steps import MissingField
from harness.score.csv_steps import EVENTS
from harness.score.scorer import Payer, can_be_paid, pay_column

HEAD = 8_192
"""The number of rows that a reward has to pay again. All rows would take long for rewards that remember."""
DIGITS = 1e-6
"""What a float of 7 digits, as C# prints them, can be off: half a unit in the last place is 5e-7 of it, and of the two
numbers in a difference both are."""
LOST_SIGNS = 0.01
"""Share of rows in which the sign of Dd may be lost: distance and best distance print alike and differ."""


class Guess(NamedTuple):
    """The guess which reward paid a run."""

    choice: str | None
    """The reward as ``harness.registry.choice.choose`` takes it; None if no reward fits."""
    reason: str = ""
    """Why no reward fits."""


def guess_reward(log: Log, registry: Registry) -> Guess:
    """The first reward that pays the run's first rows as recorded.

    Tried in this order: the one that the run's manifest declares; ``baseline``; ``arp`` with the gains that the rows
    show; every other registered reward with its defaults.
    """
    path, declared = log.facts.path, log.facts.trained_with
    if not can_be_paid(log):
        return Guess(None, f"{path} has no distances to score again")
    head = next(log.pieces(log.columns, HEAD))
    paid = head[pay_column(log)]
    if not paid.any() and not declared:
        return Guess(None, f"{path} pays nothing in its first {len(head):,} rows, as many rewards may")
    for text in dict.fromkeys([declared or "baseline", "baseline", *_arp_of(head, paid), *registry.names("rewards")]):
        try:
            if not _misfit(text, log, head, registry):
                return Guess(text)
        except (Exception, SystemExit):  # a plugin may raise anything
            continue
    besides = f"; not even {declared}, which its manifest declares" if declared else ""
    return Guess(None, f"no registered reward pays what {path} recorded{besides}")


def _arp_of(head: Rows, paid: Float) -> Iterator[str]:
    """``arp`` with the gains that the rows show, to 3 digits: k2 of what is paid, k1 of what is lost."""
    gained, lost = head["begin_distance"] - head["distance"], head["delta_distance"]
    k1, k2 = _gain(-paid, lost, lost > 0.0), _gain(paid, gained, (lost <= 0.0) & (gained > 0.0))
    if k1 is not None and k2 is not None:
        yield f"arp:k1={k1:.3g},k2={k2:.3g}"


def _gain(value: Float, metres: Float, rows: Mask) -> float | None:
    """How much is paid per metre, from rows with many metres; None without a row."""
    if not rows.any():
        return None
    large = rows & (metres >= 0.5 * metres[rows].max())
    return float(np.median(value[large] / metres[large]))


def _misfit(text: str, log: Log, head: Rows, registry: Registry) -> str:
    """The first of some rows that the reward pays otherwise; empty if there is none."""
    choice, recorded = choose(registry, "rewards", text), head[pay_column(log)]
    try:
        payer = Payer(choice.build(registry, "rewards"), log)
    except MissingField as error:
        return f"{log.facts.path}, no column tells {error.field}, which {choice.label} reads"
    paid = payer.pay(head).total
    misses = ~(np.abs(paid - recorded) <= _tolerance(paid, recorded, head))  # what it pays is finite, or a miss
    misses &= ~np.isnan(recorded)  # a training that diverged: `_require_whole` tells it
    # In these rows Dd is within what its two distances can be off.
    unsure = misses & (np.abs(head["delta_distance"]) <= 2.0 * DIGITS * head["distance"])
    if unsure.sum() <= max(1.0, LOST_SIGNS * len(paid)):
        misses &= ~unsure
    if not misses.any():
        return ""
    row = int(np.argmax(misses))
    where = f"{log.facts.path}, line {log.facts.first_line + row}"
    return f"{where}: recorded {recorded[row]:.7g}, {choice.label} pays {paid[row]:.7g}"


def _tolerance(paid: Float, recorded: Float, head: Rows) -> Float:
    """How far a reward may be off, (rows,), if all columns have 7 digits and it is as steep as it shows itself."""
    begin, distance, delta = head["begin_distance"], head["distance"], head["delta_distance"]
    change = np.maximum(np.abs(begin - distance), np.abs(delta))
    far = (change > 0.1 * change.max()) & (change > 0.0)
    steepness = float(np.nanmax(np.abs(recorded[far]) / change[far], initial=1.0))
    return DIGITS * (steepness * (begin + distance) + np.abs(paid))


@tells("format", "*decomposition", "rewards", "runs", "rows_left_out", "curve=kind", "with_events", "number", "notes")
@dataclass(frozen=True, eq=False)
class ComparedRuns(Plain):
    """Two groups of recorded runs, compared.

    Attributes:
        decomposition: Both etas, split where both rewards are known and the distances are recorded.
        curves: S_r(tau_q) by (r, q).
        rewards: What paid each group, ``baseline`` and ``proposed``; None where no registered reward did.
        runs: How many runs each group has.
        rows_left_out: The group's rows behind the shortest run of both groups: no two curves have them both.
        with_events: Whether the event terms are in the curves.
        notes: What a reader has to know of the files: budgets that were cut, copies that count once.
    """

    decomposition: Decomposition
    curves: Mapping[Pair, GroupCurve]
    rewards: dict[str, str | None]
    runs: dict[str, int]
    rows_left_out: dict[str, int]
    with_events: bool
    notes: tuple[str, ...] = ()

    format = 1

    @property
    def kind(self) -> Kind:
        """Which curve the indices are taken from."""
        return self.curves[BB].kind

    @property
    def names(self) -> Names:
        """What the two rewards are called in sentences."""
        return Names(*(self.rewards[who] or f"the {who} reward" for who in ("baseline", "proposed")))

    @property
    def number(self) -> str:
        """How much the indices changed, and how much of that is ruler, in words; see `harness.eta.headline`."""
        return number_sentence(self.names, self.decomposition.splits)


def compare_logs(
    baseline: Sequence[Log],
    proposed: Sequence[Log],
    registry: Registry,
    *,
    kind: Kind = "accumulated",
    with_events: bool = False,
    baseline_reward: str | None = None,
    proposed_reward: str | None = None,
) -> ComparedRuns:
    """Indices and etas of two groups of runs, read in lock-step: files of any length, in bounded memory.

    Args:
        baseline: Runs trained under the baseline reward.
        proposed: Runs trained under the proposed one.
        registry: Where rewards are looked up.
        kind: Which curve; see `GroupCurve`.
        with_events: Add the event terms to the shaped reward.
        baseline_reward: What paid the baseline's runs; found out if None.
        proposed_reward: The same for the proposed ones.

    Raises:
        UsageError: A file cannot be read or has no event terms, a reward that is given did not pay the runs, or
            trainings are missing: they diverged, or stopped early.
    """
    for log in (*baseline, *proposed):
        if with_events and any(name not in log for name in EVENTS):
            raise UsageError(f"{log.facts.path} has no event terms: leave out --with-events")
    groups = [
        sorted(group, key=lambda log: log.facts.seed or 0) if _seeds(group) else list(group)
        for group in (baseline, proposed)
    ]
    _require_apart(*groups)
    given = (baseline_reward, proposed_reward)
    guesses = [_reward_of(group, name, registry) for group, name in zip(groups, given, strict=True)]
    unpaid = (log.facts.path for log in (*baseline, *proposed) if not can_be_paid(log))
    reasons = [*(f"{path} has no distances to score again" for path in unpaid), *(it.reason for it in guesses)]
    missing = next(filter(None, reasons), None)
    others: list[Reward | None] = [
        None if missing or it.choice is None else choose(registry, "rewards", it.choice).build(registry, "rewards")
        for it in reversed(guesses)
    ]
    sides = _read_groups(groups, others, kind, with_events)
    _require_whole(sides)
    copied = [runs for side in sides for runs in side.copied]
    if copied:  # each of them counts once
        again = {run for _, *copies in copied for run in copies}
        groups = [[run for run in group if run not in again] for group in groups]
        sides = _read_groups(groups, others, kind, with_events)
    curves: dict[Pair, GroupCurve] = {BB: sides[0].own, KK: sides[1].own}
    if sides[0].other is not None and sides[1].other is not None:
        curves |= {KB: sides[0].other, BK: sides[1].other}
    elif missing is None:
        missing = "one group's reward is not finite on the other group's runs"
    is_same = [log.facts.path for log in groups[0]] == [log.facts.path for log in groups[1]]
    seeds, others_seeds = map(_seeds, groups)
    is_paired = is_same or (seeds == others_seeds and len(set(seeds)) == len(groups[0]))
    found = decompose(curves, is_paired, missing)
    claims = [split.outcomes for split in found.splits.values()]
    known = [claim for claim in claims if claim is not None]
    if len(known) == len(claims):  # they are made together
        found = found.with_corrected(*corrected_p(known))

    def each(told: Iterable[Any]) -> dict[str, Any]:
        return dict(zip(("baseline", "proposed"), told, strict=True))

    return ComparedRuns(
        found,
        curves,
        each(it.choice for it in guesses),
        each(map(len, groups)),
        each(side.left_out for side in sides),
        with_events,
        tuple(_notes_of(sides, copied, is_same)),
    )


# Which rewards


def _reward_of(group: Sequence[Log], given: str | None, registry: Registry) -> Guess:
    """The reward that paid a group: the one that pays every run of it as recorded."""
    guess = Guess(choose(registry, "rewards", given).label) if given else guess_reward(group[0], registry)
    for log in filter(can_be_paid, group):
        head = next(log.pieces(log.columns, HEAD))
        if guess.choice and (problem := _misfit(guess.choice, log, head, registry)):
            if given:
                raise UsageError(f"The runs were not paid by {given}: {problem}")
            return Guess(None, f"no one reward pays all runs of a group: {problem}")
    return guess


# Which runs


def _require_whole(sides: Sequence["ComparedRows"]) -> None:
    """Check that no training diverged, or stopped before the others of its group did: how it ended is an outcome.

    Raises:
        UsageError: Some did; says how to leave them out.
    """
    done = {
        run: (name, float(rows), rows)
        for side, name in zip(sides, ("the baseline", "the proposed reward"), strict=True)
        for run, rows in side.rows.items()
    }
    why = shortfall_beside(done, "steps")
    why |= {run: f"it is paid no number from step {it:,} on" for side in sides for run, it in side.torn.items()}
    account = counted([(run, run.facts.path, why.get(run, "")) for run in done])
    if account.missing:
        raise UsageError(". ".join(account.lines))


def _require_apart(baseline: Sequence[Log], proposed: Sequence[Log]) -> None:
    """Check that no file is in both groups, unless both are the same group."""
    ours, theirs = ({log.facts.path.resolve(): log.facts.path for log in group} for group in (baseline, proposed))
    for path, name in ours.items() if ours.keys() != theirs.keys() else ():
        if path in theirs:
            raise UsageError(f"'{name}' is in both groups: let --baseline and --proposed name different files")


def _seeds(group: Sequence[Log]) -> list[int]:
    """The seed of each log; empty where that of one is not known."""
    known = [log.facts.seed for log in group if log.facts.seed is not None]
    return known if len(known) == len(group) else []


HELD = 250_000
"""The most rows that are in memory at once, of all runs together."""
ROWS_SEEN = 1_000
"""Rows of a piece in which different rewards are counted."""
FEW = 10
"""So few different rewards may be paid alike in two trainings by chance; equal runs that pay more are copies."""
UNLIKE_METRES = 20.0
"""Begin distances that differ by this factor between two groups are hardly in one unit."""


class _Paid(NamedTuple):
    """What some rows of a run were paid, (rows,) each."""

    own: Float
    other: Float
    """What the other group's reward would have paid; the same as `own` where nobody asked."""


class ComparedRows:
    """One group, of which all rows are read, some steps of every run at a time.

    Attributes:
        own: The curve of what the group was paid.
        other: The curve of what the other group's reward would have paid; None if nobody asked, or it is not finite.
        rows: How many rows each run has.
        torn: The first row of a run that is paid no number, of those that have one.
    """

    def __init__(self, group: Sequence[Log], kind: Kind, is_paid_again: bool) -> None:
        self.own = GroupCurve(len(group), kind)
        self.other = GroupCurve(len(group), kind) if is_paid_again else None
        self.rows, self.torn = dict.fromkeys(group, 0), dict[Log, int]()
        self._digests = {run: hashlib.sha256() for run in group}
        self._paid: dict[Log, set[float]] = {run: set() for run in group}

    @property
    def left_out(self) -> int:
        """How many rows stand behind the shortest run of both groups."""
        return sum(self.rows.values()) - len(self.rows) * self.own.index.steps

    def add(self, pieces: Sequence[_Paid], steps: int) -> None:
        """Take the next piece of each run, of which `steps` rows are compared."""
        for run, piece in zip(self.rows, pieces, strict=True):
            if (lost := np.isnan(piece.own)).any():
                self.torn.setdefault(run, self.rows[run] + int(np.argmax(lost)))
            self.rows[run] += len(piece.own)
            self._digests[run].update(piece.own[:steps].tobytes())
            if len(self._paid[run]) <= FEW:
                self._paid[run].update(np.unique(piece.own[:steps][:ROWS_SEEN]).tolist())
        self.own.add(np.stack([piece.own[:steps] for piece in pieces]))
        if self.other is not None:
            scored = np.stack([piece.other[:steps] for piece in pieces])
            self.other.add(scored)
            self.other = self.other if is_countable(scored).all() else None

    @property
    def alike(self) -> dict[str, list[Log]]:
        """Runs that were paid the same in all compared steps, together; none that one reward alone paid throughout."""
        found: dict[str, list[Log]] = {}
        for run, digest in self._digests.items():
            if len(self._paid[run]) > 1:
                found.setdefault(digest.hexdigest(), []).append(run)
        return found

    @property
    def copied(self) -> list[list[Log]]:
        """Those of them that are more than one, and paid more different rewards than by chance alike."""
        return [runs for runs in self.alike.values() if len(runs) > 1 and len(self._paid[runs[0]]) > FEW]


def _paid_rows(run: Log, other: Reward | None, with_events: bool, rows: int) -> Iterator[_Paid]:
    """What all rows of a run were paid, so many at a time."""
    column, events, payer = pay_column(run), EVENTS if with_events else (), Payer(other, run) if other else None
    for piece in run.pieces([column, *events, *(payer.columns if payer else ())], rows):
        added = np.sum([piece[name] for name in events], axis=0)
        yield _Paid(piece[column] + added, payer.pay(piece).total + added if payer else piece[column])


def _read_groups(
    groups: Sequence[Sequence[Log]], others: Sequence[Reward | None], kind: Kind, with_events: bool
) -> list[ComparedRows]:
    """Read all rows of both groups, the same steps of every run at once, up to the end of the shortest run of all.

    The rest is read, too: a fault in it is a fault of the file.
    """
    both = list(zip(groups, others, strict=True))
    sides = [ComparedRows(group, kind, other is not None) for group, other in both]
    rows = max(1, min(ROWS, HELD // sum(map(len, groups))))
    runs = [_paid_rows(run, other, with_events, rows) for group, other in both for run in group]
    for pieces in zip_longest(*runs, fillvalue=_Paid(np.empty(0), np.empty(0))):
        steps = min(len(piece.own) for piece in pieces)
        for side, of in zip(sides, (pieces[: len(groups[0])], pieces[len(groups[0]) :]), strict=True):
            side.add(of, steps)
    return sides


# What a reader has to know


def _notes_of(sides: Sequence[ComparedRows], copied: Sequence[Sequence[Log]], is_same: bool) -> Iterator[str]:
    """What a reader has to know of copies, budgets, equal runs and units."""
    for first, *copies in copied:
        told = f"{_listed(copies)} {'is' if len(copies) == 1 else 'are'} equal to '{first.facts.path}'"
        yield f"{told}: the run counts once"
    groups = [list(side.rows) for side in sides]
    for run in (run for group in groups for run in group):
        yield from (f"'{run.facts.path}': {note}" for note in run.facts.notes)
    rows = {run.facts.path: rows for side in sides for run, rows in side.rows.items()}
    shortest = min(rows, key=rows.__getitem__)
    if max(rows.values()) > rows[shortest]:
        told = f"All runs are cut to the {rows[shortest]:,} steps of the shortest, '{shortest}'"
        yield f"{told}; the longest has {max(rows.values()):,}"
    baseline, proposed = (side.alike for side in sides)
    for runs in (*baseline.values(), *proposed.values()):
        if len(runs) > 1:
            yield f"{_listed(runs)} record the same rewards; each counts"
    for digest, runs in baseline.items():
        if digest in proposed and not is_same:
            both = [runs[0], proposed[digest][0]]
            yield f"{_listed(both)} record the same rewards: between them there is nothing to compare"
    begins = [_begin_distance(group) for group in groups]
    if begins[0] and begins[1] and not 1.0 / UNLIKE_METRES < begins[1] / begins[0] < UNLIKE_METRES:
        yield (
            f"Begin distances are {begins[0]:.3g} in the first rows of the baseline's runs and {begins[1]:.3g} in "
            "those of the proposed ones: are both in metres?"
        )


def _begin_distance(group: Sequence[Log]) -> float:
    """The mean over the first rows of runs, [m]; 0 where they have no distances."""
    heads = [next(run.pieces(["begin_distance"], HEAD)) for run in group if "begin_distance" in run]
    return float(np.mean([head["begin_distance"].mean() for head in heads])) if heads else 0.0


def _listed(runs: Sequence[Log]) -> str:
    *most, last = (f"'{run.facts.path}'" for run in runs)
    return f"{', '.join(most)} and {last}" if most else last

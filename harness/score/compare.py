"""Compares two groups of recorded runs: their indices, eta_N, eta_P, and how much of each is only a change of ruler."""

import hashlib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import zip_longest
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from harness.arrays import Float, Mask
from harness.errors import UsageError
from harness.eta import (
    BB,
    BK,
    KB,
    KK,
    Decomposition,
    GroupCurve,
    Kind,
    Names,
    Pair,
    corrected_p,
    decompose,
    number_sentence,
)
from harness.eta.laws import counted, shortfall_beside
from harness.log import Log, Rows
from harness.log.log import ROWS
from harness.registry.choice import choose
from harness.registry.registry import Registry
from harness.reward import MissingField, Reward
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
    with np.errstate(all="ignore"):  # a reward may divide by anything where it then takes another value
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


@dataclass(frozen=True, eq=False)
class ComparedRuns:
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

    @property
    def kind(self) -> Kind:
        """Which curve the indices are taken from."""
        return self.curves[BB].kind

    @property
    def number(self) -> str:
        """How much the indices changed, and how much of that is ruler, in words; see `harness.eta.number`."""
        known = [self.rewards[who] or f"the {who} reward" for who in ("baseline", "proposed")]
        return number_sentence(Names(*known), self.decomposition.splits)

    def to_json(self) -> dict[str, Any]:
        """What ``harness eta --json`` prints."""
        return {
            "format": 1,
            **self.decomposition.to_json(),
            "rewards": self.rewards,
            "runs": self.runs,
            "rows_left_out": self.rows_left_out,
            "curve": self.kind,
            "with_events": self.with_events,
            "number": self.number,
            "notes": list(self.notes),
        }


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
    bare = next((log for log in (*baseline, *proposed) if any(name not in log for name in EVENTS)), None)
    if with_events and bare is not None:
        raise UsageError(f"{bare.facts.path} has no event terms: leave out --with-events")
    groups = [_in_order_of_seeds(baseline), _in_order_of_seeds(proposed)]
    _require_apart(*groups)
    given = (baseline_reward, proposed_reward)
    guesses = [_reward_of(group, name, registry) for group, name in zip(groups, given, strict=True)]
    missing = _why_not_split([*baseline, *proposed], guesses)
    others = [None, None] if missing is not None else [_build(guess, registry) for guess in reversed(guesses)]
    stream = partial(stream_groups, others=others, kind=kind, with_events=with_events)
    sides = stream(groups)
    _require_whole(sides)
    copies = [side.copies for side in sides]
    if any(copies):
        groups = [[run for run in group if run not in of] for group, of in zip(groups, copies, strict=True)]
        sides = stream(groups)
    curves: dict[Pair, GroupCurve] = {BB: sides[0].own, KK: sides[1].own}
    if sides[0].other is not None and sides[1].other is not None:
        curves |= {KB: sides[0].other, BK: sides[1].other}
    elif missing is None:
        missing = "one group's reward is not finite on the other group's runs"
    names = ("baseline", "proposed")
    return ComparedRuns(
        _corrected(decompose(curves, _are_paired(*groups), missing)),
        curves,
        {name: guess.choice for name, guess in zip(names, guesses, strict=True)},
        {name: len(group) for name, group in zip(names, groups, strict=True)},
        {name: side.left_out for name, side in zip(names, sides, strict=True)},
        with_events,
        (*copy_notes(copies), *notes_of(sides)),
    )


def _corrected(found: Decomposition) -> Decomposition:
    """Both etas with corrected p-values, because they are claims that are made together."""
    outcomes = [split.outcomes for split in found.splits.values()]
    known = [claim for claim in outcomes if claim is not None]
    return found.with_corrected(*corrected_p(known)) if len(known) == len(outcomes) else found


# Which rewards


def _reward_of(group: Sequence[Log], given: str | None, registry: Registry) -> Guess:
    """The reward that paid a group: the one that pays every run of it as recorded."""
    if given is not None:
        choose(registry, "rewards", given)
    guess = Guess(given) if given is not None else guess_reward(group[0], registry)
    if guess.choice is None:
        return guess
    for log in filter(can_be_paid, group):
        problem = _misfit(guess.choice, log, next(log.pieces(log.columns, HEAD)), registry)
        if problem and given is not None:
            raise UsageError(f"The runs were not paid by {given}: {problem}")
        if problem:
            return Guess(None, f"no one reward pays all runs of a group: {problem}")
    return guess


def _why_not_split(logs: Sequence[Log], guesses: Sequence[Guess]) -> str | None:
    """Why the runs cannot be scored again; None if they can."""
    bare = next((log for log in logs if not can_be_paid(log)), None)
    if bare is not None:
        return f"{bare.facts.path} has no distances to score again"
    return next((guess.reason for guess in guesses if guess.choice is None), None)


def _build(guess: Guess, registry: Registry) -> Reward:
    assert guess.choice is not None  # or there is a reason not to split
    reward: Reward = choose(registry, "rewards", guess.choice).build(registry, "rewards")
    return reward


# Which runs


def _require_whole(sides: Sequence["ComparedRows"]) -> None:
    """Check that no training diverged, or stopped before the others of its group did: how it ended is an outcome.

    Raises:
        UsageError: Some did; says how to leave them out.
    """
    done = {
        run: (name, float(rows), rows)
        for side, name in zip(sides, ("the baseline", "the proposed reward"), strict=True)
        for run, rows in zip(side.group, side.rows, strict=True)
    }
    why = shortfall_beside(done, "steps")
    why |= {run: f"it is paid no number from step {it:,} on" for side in sides for run, it in side.torn.items()}
    account = counted([(run, run.facts.path, why.get(run, "")) for run in done])
    if account.missing:
        raise UsageError(". ".join(account.lines))


def _require_apart(baseline: Sequence[Log], proposed: Sequence[Log]) -> None:
    """Check that no file is in both groups, unless both are the same group."""
    ours, theirs = ({log.facts.path.resolve(): log.facts.path for log in group} for group in (baseline, proposed))
    both = [path for place, path in ours.items() if place in theirs]
    if both and ours.keys() != theirs.keys():
        raise UsageError(f"'{both[0]}' is in both groups: let --baseline and --proposed name different files")


def _in_order_of_seeds(group: Sequence[Log]) -> list[Log]:
    """The logs by seed if all seeds are known, else as given."""
    known = {log: log.facts.seed for log in group if log.facts.seed is not None}
    return sorted(group, key=lambda log: known[log]) if len(known) == len(group) else list(group)


def _are_paired(baseline: Sequence[Log], proposed: Sequence[Log]) -> bool:
    """Whether run i of both groups has the same seed, or is the same run."""
    if [log.facts.path for log in baseline] == [log.facts.path for log in proposed]:
        return True
    seeds_b, seeds_k = ([log.facts.seed for log in group] for group in (baseline, proposed))
    return seeds_b == seeds_k and None not in seeds_b and len(set(seeds_b)) == len(seeds_b)


HELD = 250_000
"""The most rows that are in memory at once, of all runs together."""
ROWS_SEEN = 1_000
"""Rows of a piece in which different rewards are counted."""
FEW = 10
"""So few different rewards may be paid alike in two trainings by chance; equal runs that pay more are copies."""
UNLIKE_METRES = 20.0
"""Begin distances that differ by this factor between two groups are hardly in one unit."""


class ComparedRows:
    """One group, of which all rows are read, some steps of every run at a time."""

    def __init__(self, group: Sequence[Log], other: Reward | None, kind: Kind, with_events: bool) -> None:
        self.group, self._with_events = group, with_events
        self.own, self._scored = GroupCurve(len(group), kind), GroupCurve(len(group), kind)
        self._payers = [Payer(other, run) for run in group] if other is not None else []
        self._finite, self.left_out = True, 0
        self.rows = [0] * len(group)
        self.torn: dict[Log, int] = {}
        self._digests = [hashlib.sha256() for _ in group]
        self._values: list[set[float]] = [set() for _ in group]
        self._metres, self._starts = 0.0, 0

    @property
    def other(self) -> GroupCurve | None:
        """The curve of what the other group's reward would have paid; None if nobody asked, or it is not finite."""
        return self._scored if self._payers and self._finite else None

    @property
    def begin_distance(self) -> float | None:
        """The mean over all compared rows, [m]; None where the files have no distances."""
        return self._metres / self._starts if self._starts else None

    def pieces(self, rows: int) -> list[Iterator[Rows]]:
        """The rows of each run, so many at a time, of the columns that are compared."""
        read = []
        for number, run in enumerate(self.group):
            paid = (pay_column(run), *(EVENTS if self._with_events else ()))
            more = (name for name in ("begin_distance",) if name in run)
            read.append(run.pieces([*paid, *more, *(self._payers[number].columns if self._payers else ())], rows))
        return read

    def add(self, pieces: Sequence[Rows | None], steps: int) -> None:
        """Take the next piece of each run, of which `steps` rows are compared."""
        there = [piece for piece in pieces if piece is not None]
        for run, piece, before in zip(self.group, pieces, self.rows, strict=True):
            if piece is not None and (lost := np.isnan(piece[pay_column(run)])).any():
                self.torn.setdefault(run, before + int(np.argmax(lost)))
        self.rows = [rows + (len(it) if it else 0) for rows, it in zip(self.rows, pieces, strict=True)]
        self.left_out += sum(len(piece) - steps for piece in there)
        if not steps:
            return
        recorded = [piece[pay_column(run)] for piece, run in zip(there, self.group, strict=True)]
        paid = self._with_event_terms(there, recorded, steps)
        self.own.add(paid)
        for digest, values, run in zip(self._digests, self._values, paid, strict=True):
            digest.update(run.tobytes())
            if len(values) <= FEW:
                values.update(np.unique(run[:ROWS_SEEN]).tolist())
        for begin in (piece["begin_distance"] for piece in there if "begin_distance" in piece.columns):
            self._metres, self._starts = self._metres + float(begin[:steps].sum()), self._starts + steps
        if self._payers and self._finite:
            with np.errstate(all="ignore"):  # a reward may divide by anything where it then takes another value
                scored = [payer.pay(piece).total for payer, piece in zip(self._payers, there, strict=True)]
            values_of_other = self._with_event_terms(there, scored, steps)
            self._finite = bool(np.isfinite(values_of_other).all())
            self._scored.add(values_of_other)

    def _with_event_terms(self, pieces: Sequence[Rows], paid: Sequence[Float], steps: int) -> Float:
        """What the first `steps` rows of each piece are paid, (runs, steps)."""
        if self._with_events:
            events = (np.sum([piece[name] for name in EVENTS], axis=0) for piece in pieces)
            paid = [shaped + event for shaped, event in zip(paid, events, strict=True)]
        return np.stack([run[:steps] for run in paid])

    def digests(self, certain: bool) -> dict[str, list[Log]]:
        """Runs by what was paid in all compared steps.

        Args:
            certain: Of those that paid more different rewards than by chance alike, or of the others that vary at all.
        """
        found: dict[str, list[Log]] = {}
        for run, digest, values in zip(self.group, self._digests, self._values, strict=True):
            if (len(values) > FEW) == certain and len(values) > 1:
                found.setdefault(digest.hexdigest(), []).append(run)
        return found

    @property
    def copies(self) -> dict[Log, Log]:
        """Each run that is a copy, and the one that it is a copy of."""
        return {copy: runs[0] for runs in self.digests(certain=True).values() for copy in runs[1:]}


def stream_groups(
    groups: Sequence[Sequence[Log]], others: Sequence[Reward | None], kind: Kind, with_events: bool
) -> list[ComparedRows]:
    """Read all rows of both groups, the same steps of every run at once, up to the end of the shortest run of all.

    The rest is read, too: a fault in it is a fault of the file.
    """
    count = len(groups[0])
    runs = [run for group in groups for run in group]
    rows = max(1, min(ROWS, HELD // len(runs)))
    sides = [ComparedRows(group, other, kind, with_events) for group, other in zip(groups, others, strict=True)]
    for pieces in zip_longest(*(of_run for side in sides for of_run in side.pieces(rows))):
        steps = min(0 if piece is None else len(piece) for piece in pieces)
        for side, of in zip(sides, (pieces[:count], pieces[count:]), strict=True):
            side.add(of, steps)
    return sides


# What a reader has to know


def copy_notes(copies: Sequence[Mapping[Log, Log]]) -> Iterator[str]:
    """Which runs count once."""
    for of in copies:
        copied: dict[Path, list[Path]] = {}
        for copy, first in of.items():
            copied.setdefault(first.facts.path, []).append(copy.facts.path)
        for path, others in copied.items():
            yield f"{_listed(others)} {'is' if len(others) == 1 else 'are'} equal to '{path}': the run counts once"


def notes_of(sides: Sequence[ComparedRows]) -> Iterator[str]:
    """What a reader has to know of budgets, equal runs and units."""
    for run in (run for side in sides for run in side.group):
        yield from (f"'{run.facts.path}': {note}" for note in run.facts.notes)
    lengths = {run.facts.path: rows for side in sides for run, rows in zip(side.group, side.rows, strict=True)}
    shortest = min(lengths, key=lambda path: lengths[path])
    longer = [rows for rows in lengths.values() if rows > lengths[shortest]]
    if longer:
        told = f"All runs are cut to the {lengths[shortest]:,} steps of the shortest, '{shortest}'"
        yield f"{told}; the longest has {max(longer):,}"
    for side in sides:
        for runs in side.digests(certain=False).values():
            if len(runs) > 1:
                yield f"{_listed([run.facts.path for run in runs])} record the same rewards; each counts"
    if [run.facts.path for run in sides[0].group] != [run.facts.path for run in sides[1].group]:
        yield from _equal_across(*({**side.digests(True), **side.digests(False)} for side in sides))
    begins = [side.begin_distance for side in sides]
    if begins[0] and begins[1] and not 1.0 / UNLIKE_METRES < begins[1] / begins[0] < UNLIKE_METRES:
        yield (
            f"Begin distances are {begins[0]:.3g} in the baseline's runs and {begins[1]:.3g} in the proposed ones: "
            "are both in metres?"
        )


def _equal_across(baseline: Mapping[str, list[Log]], proposed: Mapping[str, list[Log]]) -> Iterator[str]:
    for digest in baseline.keys() & proposed.keys():
        both = [baseline[digest][0].facts.path, proposed[digest][0].facts.path]
        yield f"{_listed(both)} record the same rewards: between them there is nothing to compare"


def _listed(paths: Sequence[Path]) -> str:
    *most, last = (f"'{path}'" for path in paths)
    return f"{', '.join(most)} and {last}" if most else last

"""The laws that hold for every training, whatever kept it: an own experiment, a recording, a log of another program.

Each stands here once, and every door calls it.

* **Direction**, `direction_of`: a measure says better or worse only where somebody said which is better, and nobody the
  contrary, or where it is 0 or 1. One that decides has to have a direction before anything is trained or read.
* **Ends**, `ends_of`: a plain word needs to know how bad and how good a training can be, never from the data.
* **Missing is an outcome**, `counted`: a training that failed, stopped early or cannot be read stays in the count. A
  verdict waits for it, unless the user leaves it out by name.
* **Times, not rows**, `Curve.mean`, `Curves.known`, `latest_shared`: what is compared stands on one span of environment
  steps, or at one moment, however often somebody logged.
* **Support**, `Curve.since`, `within`: a value knows which steps it averages. Where values say too little of a span,
  nothing is said of it.
* **Units**, `require_share`: a share lies from 0 to 1 in all trainings, or is refused for all of them.
"""

from collections.abc import Callable, Collection, Hashable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from itertools import count
from pathlib import Path
from typing import Generic, Literal, NamedTuple, TypeAlias, TypeVar

import numpy as np

from harness.arrays import Float
from harness.errors import UsageError
from harness.eta.interval import SHARE, UNBOUNDED, Bounds, are_within

Better: TypeAlias = Literal["higher", "lower", ""]
"""Which values of a measure are better; empty where nobody said it."""
T = TypeVar("T", bound=Hashable)
NEARLY_ALL = 0.95
"""A training that has this share of its steps is whole: its last episode need not have ended."""
LATE = 0.2
"""A training that lacks more than this share of its steps before its first value is cut there."""
NEAR = 0.002
"""Evaluations at most this share of their steps apart are of one moment, as of 3 environments that step together."""
LEAST_KNOWN = 0.5
"""The share of a span of which values have to tell; of less nothing is said."""
LEAST_POINTS = 3
"""So many values have to stand in a span of each training; fewer tell more of the grid than of the training."""


# Direction


def direction_of(name: str, lower: Collection[str], higher: Collection[str], *, is_flag: bool) -> Better:
    """Which values of a measure are better.

    Args:
        name: The measure.
        lower: Measures of which somebody said that less is better.
        higher: The same of more.
        is_flag: Whether it is 0 or 1 in every episode, as success is: more is better then, unless somebody said else.

    Returns:
        Empty where nobody said it, or somebody said both.
    """
    if name in lower:
        return "" if name in higher else "lower"
    return "higher" if name in higher or is_flag else ""


def may_be_flag(value: float) -> bool:
    """Whether a number is 0 or 1, as of a flag, or is not known."""
    return value in (0.0, 1.0) or bool(np.isnan(value))


def require_direction(name: str, better: str, how: str) -> None:
    """Check that it is known of a measure that decides which values are better.

    Raises:
        UsageError: It is not; `how` says what to type.
    """
    if not better:
        raise UsageError(
            f"Measure '{name}' decides, and nobody says whether less or more of it is better, or both are said: {how}"
        )


# Ends


def ends_of(name: str, known: Bounds, told: Mapping[str, Bounds], values: Collection[float]) -> Bounds:
    """The least and the greatest value that a training can have, by what the user says or else what is known.

    Ends that are known and that a value leaves are none. They are never taken from the values.

    Raises:
        UsageError: A value leaves what the user says, or a share has its own.
    """
    ends = told.get(name, known)
    if known == SHARE != ends:
        raise UsageError(
            f"--ends {name}={ends[0]:g},{ends[1]:g}: {name} is a share, from 0 to 1, which is known: leave it out"
        )
    beyond = [it for it in values if not are_within([it], ends)]
    if beyond and name in told:
        raise UsageError(
            f"--ends {name}={ends[0]:g},{ends[1]:g}: {name} is {beyond[0]:g} in a training. Say the least and the "
            "greatest value that it can have"
        )
    return UNBOUNDED if beyond else ends


# Missing is an outcome


class Missing(NamedTuple):
    """A training that was begun and has no value which could be compared."""

    path: Path
    """Its file or folder."""
    why: str


class Account(NamedTuple, Generic[T]):
    """All trainings that were begun."""

    whole: tuple[T, ...]
    missing: tuple[Missing, ...]
    """A verdict waits for them."""
    left_out: tuple[Missing, ...]
    """Those that the user left out."""

    @property
    def lines(self) -> tuple[str, ...]:
        """What to tell of those that are not whole."""
        typed = (f"'{it.path}' is left out, as --leave-out says{': ' * bool(it.why)}{it.why}" for it in self.left_out)
        told = [f"'{it.path}' is missing: {it.why.replace(f'{it.path} ', 'it ', 1)}" for it in self.missing]
        return (*typed, *told, *([self.remedy] if told else ()))

    @property
    def remedy(self) -> str:
        """The flags that leave out what is missing."""
        flags = " ".join("--leave-out '" + str(it.path).replace("'", "'\\''") + "'" for it in self.missing)
        return f"No verdict without what is missing: how it ended is an outcome too. {flags} leaves it out"


def is_left_out(path: Path, leave_out: Collection[Path]) -> bool:
    """Whether a file or a folder is among those that the user leaves out; a folder with all that lies in it."""
    return any(path.absolute().is_relative_to(it.absolute()) for it in leave_out)


def counted(trainings: Iterable[tuple[T | None, Path, str]], leave_out: Collection[Path] = ()) -> Account[T]:
    """The account of all trainings that were begun.

    Args:
        trainings: Each with its file or folder, and why it is not whole, empty if it is; None of one that cannot be
            read.
        leave_out: See `is_left_out`.

    Raises:
        UsageError: No training lies at one of these.
    """
    begun = list(trainings)
    unused = [out for out in leave_out if not any(is_left_out(path, [out]) for _, path, _ in begun)]
    if unused:
        raise UsageError(
            f"--leave-out {unused[0]}: no training lies there, but at {', '.join(str(it[1]) for it in begun[:2])}"
        )
    whole, missing, left = list[T](), list[Missing](), list[Missing]()
    for training, path, why in begun:
        if is_left_out(path, leave_out):
            left.append(Missing(path, why))
        elif why or training is None:
            missing.append(Missing(path, why))
        else:
            whole.append(training)
    return Account(tuple(whole), tuple(missing), tuple(left))


def numbered(told: Sequence[tuple[str, int | None]]) -> list[int]:
    """The seed of each training: one that tells none gets the lowest that is free.

    Args:
        told: The reward that taught each, and the seed that it tells.
    """
    taken, found = {*told}, list[int]()
    for reward, own in told:
        seed = next(it for it in count() if (reward, it) not in taken) if own is None else own
        taken.add((reward, seed))
        found.append(seed)
    return found


def shortfall_beside(done: Mapping[T, tuple[str, float, int]], noun: str) -> dict[T, str]:
    """Why trainings are not whole that stopped before others of their reward did, which followed one plan.

    Args:
        done: The reward that taught each, and how much of it was done, counted in `noun`, and in rows: a plan may be of
            either.
        noun: What the first number counts, ``steps``.
    """
    most: dict[str, tuple[float, int]] = {}
    for reward, length, rows in done.values():
        longest, fullest = most.get(reward, (0.0, 0))
        most[reward] = max(longest, length), max(fullest, rows)
    found = {}
    for it, (reward, length, rows) in done.items():
        longest, fullest = most[reward]
        if length < NEARLY_ALL * longest and rows < NEARLY_ALL * fullest:
            found[it] = f"it ends after {length:,.0f} {noun}, and another one of {reward} after {longest:,.0f}"
    return found


# Times, and the steps that a value averages


class Span(NamedTuple):
    """A part of a training, in environment steps."""

    begin: float
    end: float


def shortfall_at_begin(spans: Mapping[T, Span], noun: str) -> dict[T, str]:
    """Why trainings are not whole that begin later than others: they may be what another file goes on with.

    Args:
        spans: Of which steps the values of each training tell.
        noun: As of `shortfall_beside`.
    """
    first = min((it.begin for it in spans.values()), default=0.0)
    return {
        it: f"it begins after {begin:,.0f} {noun}, and another one after {first:,.0f}"
        for it, (begin, end) in spans.items()
        if begin - first > LATE * end
    }


@dataclass(frozen=True, eq=False)
class Curve:
    """Where the values of one training stand in its environment steps, (points,) each, rising.

    Attributes:
        after: Steps that were taken when each value was told.
        since: Steps before the first of what a value averages; `after` itself of one that averages no steps, such as an
            evaluation; NaN where nobody knows.
    """

    after: Float
    since: Float

    @property
    def at(self) -> Float:
        """The steps for which each value stands: the middle of what it averages."""
        return np.maximum.accumulate((self.after + self.since) / 2.0)

    @property
    def known(self) -> Span:
        """From where to where values stand; begins after its end where there is none."""
        return Span(float(self.at[0]), float(self.at[-1])) if len(self.after) else Span(np.inf, -np.inf)

    def count(self, over: Span) -> int:
        """How many values stand in a span."""
        return int(((self.at >= over.begin) & (self.at <= over.end)).sum())

    def mean(self, values: Float, over: Span) -> float | None:
        """The mean over the steps of a span, of straight lines between values, (points,); None where one is NaN.

        Points that are shifted, left out or added on the lines tell the same mean.
        """
        at = self.at
        if not len(at):
            return None
        inside = at[(at > over.begin) & (at < over.end)]
        knots = np.concatenate([[over.begin], inside, [over.end]])
        heights = np.interp(knots, at, values)
        length = over.end - over.begin
        found = float(np.trapezoid(heights, knots) / length) if length > 0.0 else float(heights[0])
        return None if np.isnan(found) else found


@dataclass(frozen=True, eq=False)
class Curves:
    """Learning curves that are compared: none is asked about a span of which another one says too little."""

    curves: tuple[Curve, ...]
    _counts: dict[Span, int] = field(default_factory=dict)

    @cached_property
    def known(self) -> Span:
        """Where the values of all of them stand."""
        begins, ends = zip(*(it.known for it in self.curves), strict=True)
        return Span(max(begins), min(ends))

    def fewest(self, over: Span) -> int:
        """How many values stand in a span, of the curve that has the fewest there."""
        if over not in self._counts:
            self._counts[over] = min(it.count(over) for it in self.curves)
        return self._counts[over]


def within(asked: Span, known: Span) -> Span | None:
    """What is known of a span that is asked for; None where that is less than `LEAST_KNOWN` of it."""
    found = Span(max(asked.begin, known.begin), min(asked.end, known.end))
    least = LEAST_KNOWN * (asked.end - asked.begin) * (1 - 1e-9)
    return found if 0.0 <= found.end - found.begin >= least else None


def latest_shared(times: Sequence[Sequence[float]], begin: float = 0.0) -> list[int] | None:
    """For each training the place of its evaluation at the latest moment at which all were evaluated; None without one.

    Args:
        times: Steps before each evaluation of each training, rising.
        begin: No moment before this counts.
    """
    for moment in sorted((it for it in times[0] if it >= begin), reverse=True):
        places = [int(np.argmin(np.abs(np.asarray(of) - moment))) for of in times]
        if all(abs(of[place] - moment) <= NEAR * moment for of, place in zip(times, places, strict=True)):
            return places
    return None


# Units


def require_share(name: str, values: Mapping[T, Float], shown: Callable[[T], str]) -> None:
    """Check that a share lies from 0 to 1 in all trainings; NaN says that it is not known.

    Args:
        name: What the share is called.
        values: Of each training, (rows,).
        shown: What a training is called in words.

    Raises:
        UsageError: It lies beyond in some: they may be told in percent, and a look at those that fit would lie.
    """
    wrong = {it: beyond for it, of in values.items() if len(beyond := of[(of < 0.0) | (of > 1.0)])}
    if wrong:
        first, of = next(iter(wrong.items()))
        raise UsageError(
            f"{name} is a share from 0 to 1, and is {of[0]:g} in {shown(first)}, one of {len(wrong)} of {len(values)} "
            "trainings. If it is told in percent, divide it by 100 in all of them"
        )

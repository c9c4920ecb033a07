"""A training by its finished episodes, whatever log it comes from."""

from abc import ABC, abstractmethod
from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from types import MappingProxyType
from typing import NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from harness.arrays import Float, Mask
from harness.errors import SchemaError, UsageError
from harness.eta.interval import SHARE, UNBOUNDED, Bounds, are_within
from harness.eta.laws import LEAST_POINTS, Curve, Curves, Span, within
from harness.log import Log
from harness.log.log import BEHAVIOUR, REWARD, SINCE, SUCCESS, TIME, OpenEpisodes, are_flags, episode_rows
from harness.record.recording.facts import TrainingFacts, facts_of
from harness.results.by_term import part_of
from harness.results.metrics import Measured, Moment, Values
from harness.reward.steps import ENDS

UNKNOWN = "not a number in some episodes"
LAST_SHARE = 0.2
"""The last part of a training, as a share of its steps."""


class Part(NamedTuple):
    """What the episodes of a stretch of a training come to: means over these episodes."""

    episodes: int
    returns: Mapping[str, float | None]
    """By reward; None where there is none."""
    behaviour: Mapping[str, float | None]
    """By measure."""
    reasons: Mapping[str, str]
    """Why there is none, by the names of both."""


@dataclass(frozen=True, eq=False)
class Episodes:
    """The finished episodes of a training, in the order in which they ended. All arrays are (episodes,).

    Attributes:
        last: Environment steps of the training that were taken before the last one of each.
        returns: By reward, the sum over the episode; NaN where the reward was given up.
        behaviour: By measure, the value in its last step; NaN where the measure was given up.
        reasons: By column of a reward or a measure that is not known: why.
    """

    last: NDArray[np.int64]
    returns: Mapping[str, Float]
    behaviour: Mapping[str, Float]
    reasons: Mapping[str, str]

    @property
    def numbers(self) -> Float:
        """All of its arrays, a row each, (1 + rewards + measures, episodes); `of` makes the same of them again."""
        return np.array([self.last, *self.returns.values(), *self.behaviour.values()], dtype=np.float64)

    @classmethod
    def of(cls, facts: TrainingFacts, numbers: Float) -> Self:
        """The episodes of a log.

        Args:
            facts: What is known of it beside its rows.
            numbers: What `numbers` told of its episodes.
        """
        last, returns, behaviour = np.split(numbers, [1, 1 + len(facts.rewards)])
        return cls(
            last[0].astype(np.int64),
            dict(zip(facts.rewards, returns, strict=True)),
            dict(zip(facts.behaviour, behaviour, strict=True)),
            {failed.column: failed.told for failed in facts.failed},
        )

    def part(self, begin: int, end: int) -> Part:
        """The episodes that ended in the rows from `begin` to `end`, the latter not included."""
        inside = slice(*np.searchsorted(self.last, [begin, end]).tolist())
        return self._part(len(self.last[inside]), lambda values: float(values[inside].mean()), "no episode ended")

    def _part(self, count: int, mean: Callable[[Float], float | None], why_none: str) -> Part:
        """What so many episodes come to, by the mean of each column; without any, why there are none."""
        found: dict[str, dict[str, float | None]] = {REWARD: {}, BEHAVIOUR: {}}
        reasons = {}
        for kind, columns in ((REWARD, self.returns), (BEHAVIOUR, self.behaviour)):
            for name, values in columns.items():
                told = mean(values) if count else None
                found[kind][name] = None if told is None or np.isnan(told) else told
                if found[kind][name] is None:
                    reasons[name] = self.reasons.get(f"{kind}{name}", UNKNOWN) if count else why_none
        return Part(count, found[REWARD], found[BEHAVIOUR], reasons)

    def end(self, steps: int) -> Part:
        """The last fifth of so many steps, in rows."""
        return self.part(round((1.0 - LAST_SHARE) * steps), steps)

    @property
    def whole(self) -> Part:
        """All of them."""
        return self.part(0, int(self.last.max(initial=-1)) + 1)

    @property
    def ends(self) -> tuple[Part, Part]:
        """The first ones and the last ones; see `harness.results.by_term.part_of`."""
        last, count = self.last.tolist() or [-1], min(part_of(len(self.last)), len(self.last)) or 1
        return self.part(0, last[count - 1] + 1), self.part(last[-count], last[-1] + 1)

    def knows(self, reward: str) -> bool:
        """Whether it is known what a reward paid all episodes."""
        return f"{REWARD}{reward}" not in self.reasons

    def without(self, reward: str, reason: str) -> "Episodes":
        """The same episodes, of which it is not known what a reward paid them."""
        returns = {**self.returns, reward: np.full(len(self.last), np.nan)}
        return replace(self, returns=returns, reasons={**self.reasons, f"{REWARD}{reward}": reason})

    def is_flag(self, measure: str) -> bool:
        """Whether a measure is 0 or 1 in every episode that has it: its mean is a share of episodes."""
        return are_flags(self._known(measure))

    def is_within(self, measure: str, bounds: Bounds) -> bool:
        """Whether a measure lies within bounds in every episode that has it."""
        return are_within(self._known(measure), bounds)

    def _known(self, measure: str) -> Float:
        values: Float = np.asarray(self.behaviour.get(measure, ()))
        return values[~np.isnan(values)]


def can_be(measure: str, each: Collection[Episodes], said: Bounds) -> Bounds:
    """What a measure can be, which no interval of it leaves.

    It is 0 to 1 where the measure is 0 or 1 in every episode. Else it is what was said, or 0 to 1 of success where
    nothing was. A measure that left this has no bounds.
    """
    if all(it.is_flag(measure) for it in each):
        return SHARE
    bounds = SHARE if said == UNBOUNDED and measure == SUCCESS else said
    return bounds if all(it.is_within(measure, bounds) for it in each) else UNBOUNDED


@dataclass(frozen=True, eq=False)
class Points(Episodes):
    """The points of a learning curve. What they come to is a mean over steps and never over rows.

    Attributes:
        since: Steps before the first that each averages, (points,); see `harness.eta.laws.Curve`.
        beside: The curves that it is compared with, and its own.
    """

    since: Float
    beside: Curves

    @property
    def curve(self) -> Curve:
        """Where they stand."""
        return Curve((self.last + 1).astype(np.float64), self.since)

    def part(self, begin: int, end: int) -> Part:
        """What is known of the steps from `begin` to `end`, where all curves stand."""
        known = self.beside.known
        over = within(Span(begin, end), known)
        if over is None:
            why = f"all curves stand from {known.begin:,.0f} to {known.end:,.0f} steps only"
            if known.begin > known.end:
                why = "no step lies on all curves"
            return self._part(0, np.mean, why)
        return self._part(max(1, self.curve.count(over)), lambda values: self.curve.mean(values, over), "")

    def end(self, steps: int) -> Part:
        """The last fifth, where at least `LEAST_POINTS` of each curve stand in it: fewer tell more of the grid."""
        over = within(Span(round((1.0 - LAST_SHARE) * steps), steps), self.beside.known)
        if over is None or self.beside.fewest(over) >= LEAST_POINTS:
            return super().end(steps)
        return self._part(0, np.mean, f"fewer than {LEAST_POINTS} points of a curve stand in its last fifth")


class Did(ABC):
    """What one training did, whatever was kept of it: that gives values, and here stands what they come to.

    Attributes:
        cut: How many of its steps are compared.
        episodes: All that ended.
        reasons: Why a measure failed, whatever the manner.
    """

    cut: int
    episodes: Episodes
    reasons: Mapping[str, str] = MappingProxyType({})

    @property
    @abstractmethod
    def _manners(self) -> Mapping[str, Part]:
        """What its policy did; what says most about its final policy comes first."""

    @property
    @abstractmethod
    def _evaluated(self) -> Mapping[int, Part]:
        """Its evaluations by the steps before them, in order."""

    @property
    @abstractmethod
    def _floor(self) -> Values:
        """What random actions did, by measure."""

    @property
    def budget(self) -> int:
        """After how many steps its final policy was evaluated."""
        return self.cut

    @property
    def motion(self) -> str:
        """A digest of all that its final policy did in its evaluation: equal where policies take the same steps.

        Empty where none is known, as of a recording, which need not hold the actions.
        """
        return ""

    @cached_property
    def _acted(self) -> Measured:
        did = {manner: dict(part.behaviour) for manner, part in self._manners.items()}
        return Measured(did, {manner: part.episodes for manner, part in self._manners.items()}, {}, self.reasons)

    @property
    def measured(self) -> Measured:
        """Every measure, by manner."""
        return self._acted._replace(random=self._floor)

    @cached_property
    def moments(self) -> tuple[Moment, ...]:
        """Its evaluations, the one after the training last."""
        return tuple(Moment(after, part.behaviour) for after, part in self._evaluated.items())

    def reason(self, name: str, manner: str) -> str:
        """Why a measure has no value; empty if it has one."""
        part = self._manners.get(manner)
        lacks = part is not None and part.behaviour.get(name) is None
        return self.reasons.get(name, "") or (self._why(name, part) if lacks else "")

    def on_the_way(self, every: int) -> Mapping[int, tuple[int, Part]]:
        """Its evaluations, and the steps before each, by the step at which they were due; the last one by its budget.

        Algorithms that act for several steps at a time do not all hit a multiple of `every`. Empty where there is none
        before the end.
        """
        if len(self._evaluated) < 2 or max(self._evaluated) < self.budget:
            return {}
        budget = self.budget
        return {budget if it >= budget else it // every * every: (it, of) for it, of in self._evaluated.items()}

    def ends(self) -> tuple[Part, Part, Part | None]:
        """Its first episodes, its last ones, and those of its evaluation, where there is one."""
        return *self.episodes.ends, self._evaluated.get(self.cut)

    def _why(self, name: str, part: Part | None) -> str:
        return ""


def episodes_of(log: Log) -> Episodes:
    """The episodes of a log, or its points; an episode that had not ended is left out.

    Where no column tells when episodes end, one has ended if another follows in its env. Where none tells how many
    steps were taken before the rows of episodes or points, the rows are counted.

    Raises:
        SchemaError: It is damaged.
    """
    facts = facts_of(log)
    numbers = _of_steps(log.without_starts(), facts) if facts.unit == "step" else _of_rows(log, facts)
    found = Episodes.of(facts, numbers)
    if facts.unit != "point":
        return found
    after = (found.last + 1).astype(np.float64)
    since: Float = np.asarray(log[SINCE], np.float64) if SINCE in log else after
    return Points(**vars(found), since=since, beside=Curves((Curve(after, since),)))


def require_ends(log: Log) -> None:
    """Check that a log of steps itself tells where episodes end.

    Raises:
        UsageError: It does not.
    """
    if log.facts.unit == "step" and not any(name in log for name in ENDS):
        raise UsageError(f"'{log.facts.path}' does not tell where episodes end: no column 'terminated' or 'truncated'")


def _of_rows(log: Log, facts: TrainingFacts) -> Float:
    """What `Episodes.of` takes, of a log whose rows are episodes, or points."""
    rows = log.rows([*([TIME] if TIME in log else []), *facts.numbers])
    ended = rows[TIME] - 1 if TIME in rows else np.arange(len(rows))
    if (np.diff(ended) < 0).any():
        raise SchemaError(f"{facts.path}: its {facts.unit}s do not stand in the order of time")
    return np.array([ended, *(rows[name] for name in facts.numbers)], dtype=np.float64)


def _of_steps(log: Log, facts: TrainingFacts) -> Float:
    """What `Episodes.of` takes, of a log of steps, a piece at a time: the sums of open episodes go on in the next."""
    ends = [name for name in ENDS if name in log]
    if not ends:
        log, ends = log.add({ENDS[1]: _followed(log)}), [ENDS[1]]
    place = [name for name in ("env", "episode") if name in log]
    paid = [f"{REWARD}{name}" for name in facts.rewards]
    going, taken = OpenEpisodes.none(len(paid)), 0
    found: list[Float] = [np.empty((1 + len(facts.numbers), 0))]
    for steps in log.pieces([*place, *ends, *facts.numbers]):
        env, episode = (steps[name] if name in place else np.zeros(len(steps)) for name in ("env", "episode"))
        is_last = np.logical_or.reduce([steps[name] for name in ends])
        going, rows, sums = going.after(env, episode, is_last, [steps[name] for name in paid])
        did = [steps[f"{BEHAVIOUR}{name}"][rows] for name in facts.behaviour]
        found.append(np.array([rows + taken, *sums, *did], dtype=np.float64))
        taken += len(steps)
    return np.concatenate(found, axis=1)


def _followed(log: Log) -> Mask:
    """Which steps are the last of an episode that another one follows in its env, (steps,)."""
    found = np.zeros(len(log), bool)
    env, episode = (np.asarray(log[name], np.int64) if name in log else found for name in ("env", "episode"))
    last = np.array([rows[-1] for rows in episode_rows(env, episode)], np.int64)  # by env
    found[last[:-1][env[last[:-1]] == env[last[1:]]]] = True
    return found


def count_text(number: int, noun: str) -> str:
    """A number of things, ``3 episodes``."""
    return f"{number:,} {noun}" + "s" * (number != 1)


def cut_notes(steps: Mapping[str, int], noun: str = "steps") -> list[str]:
    """A line that trainings went on after the shortest had ended; none where all are of one length.

    Args:
        steps: How long each was, by what it is called.
        noun: What is counted.
    """
    last = min(steps, key=steps.__getitem__)
    longer = [it for it in steps.values() if it > steps[last]]
    told = f"All are cut to the {steps[last]:,} {noun} of the shortest, {last}: {count_text(len(longer), 'training')}"
    return [f"{told} went on, for {max(longer):,} {noun} at most"] if longer else []


def unended_text(facts: TrainingFacts, steps: float) -> str:
    """What to do where no episode of a training ended, in each of whose envs so many steps were taken."""
    limit = facts.spec.get("max_episode_steps")
    if isinstance(limit, int) and steps < limit:
        longer = f"train for {limit * facts.num_envs:,} steps or more: an episode takes up to {limit:,}"
        return f"{longer}, and each of {count_text(facts.num_envs, 'env')} took {steps:,.0f}"
    return "give the environment a time limit"


def cut_text(cut: int, episodes: int, horizon: int) -> str:
    """How many of the episodes of evaluations were cut at the horizon, in words."""
    return f"{cut:,} of {episodes:,} evaluation episodes were cut after {horizon:,} steps"

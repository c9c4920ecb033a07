"""A data set paid by several rewards: what is kept of each step and of each episode. Observations are not."""

import hashlib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from harness.arrays import Float, Ints, Mask
from harness.errors import HarnessError, SchemaError, Unscored, one_line
from harness.log import Log, Rows
from harness.log.log import (
    ACTION,
    BEFORE,
    BEHAVIOUR,
    FILE,
    INFO,
    OBSERVATION,
    OPERATOR,
    RECORDED,
    REWARD,
    SEEN,
    SUCCESS as SUCCESS_NAME,
    TASK,
    UNCOUNTABLE,
    Array,
    episode_sum,
    is_countable,
    sums_from,
)
from harness.payoff.dataset.rewards import Recorded
from harness.payoff.dataset.steps import Movement, Payer, seen_after, steps_by_episode
from harness.record.dataset.labels import FAILURE, SUCCESS, UNKNOWN
from harness.record.dataset.open_dataset import MOST_EPISODES, DatasetFacts, dataset_facts
from harness.reward import Paid
from harness.reward.steps import ENDS

if TYPE_CHECKING:
    from harness.score.places import ArmPlaces


class Fingerprint:
    """A digest of what was seen, done and paid in an episode, as float32; pieces of any size give the same."""

    def __init__(self) -> None:
        self.has_fractions = False
        """Whether an observation or an action is no whole number: by chance they are not equal in two episodes."""
        self._parts: dict[str, hashlib.blake2b] = {}

    def take(self, rows: Rows) -> None:
        """The next steps. What was seen before the first one belongs to them."""
        for name, values in rows.columns.items():
            is_vector = name.startswith((OBSERVATION, ACTION))
            if is_vector or name.startswith(REWARD):
                self._add(name, values)
            elif name.startswith(BEFORE) and rows["step"][0] <= 1:
                self._add(name, values[:1])
            self.has_fractions = self.has_fractions or (is_vector and values.dtype.kind == "f" and values.size > 0)

    def digest(self) -> bytes:
        """All steps so far, as some bytes."""
        return b"".join(name.encode() + b"\0" + self._parts[name].digest() for name in sorted(self._parts))

    def _add(self, name: str, values: Array) -> None:
        if name not in self._parts:
            self._parts[name] = hashlib.blake2b(digest_size=16)
        with np.errstate(over="ignore", invalid="ignore"):
            self._parts[name].update((np.ascontiguousarray(values, np.float32) + np.float32(0.0)).tobytes())


MOST_STEPS = 20_000_000
"""The most steps of a data set: one number of each is kept, and one for each reward, 0.32 GB with one reward."""
STILL = 0.05
"""A step that moves less than this part of the root mean square of all steps is one in which nothing happens."""


@dataclass(frozen=True, eq=False)
class PaidDataset:
    """What several rewards pay for a data set. Equal episodes are there once.

    Attributes:
        facts: Of the data set.
        paid: By reward, what it pays each step, (steps,); NaN where it cannot be known, since nothing is known of what
            was seen after the step, or where it paid no finite number.
        failed: By reward that could not pay: why.
        lost: By reward, the episodes in which it pays a step no finite number, or no step at all, (episodes,).
        moved: How far each step moved, (steps,), relative to the others; NaN where nothing is known of what was seen
            after it, infinite where observations hold no finite numbers.
        begins: Number of the first step of each episode, and behind the last the number of all steps, (episodes + 1,).
        episodes: What is known of each.
        all_numbers: Of all episodes, also of those that are left out.
        notes: What was left out, a line each.
        told_by: The reward whose pay says what succeeded; empty if something else does.
        terms: By reward that pays terms, what each term pays each step, (steps,); NaN where `paid` is.
    """

    facts: DatasetFacts
    paid: Mapping[str, Float]
    failed: Mapping[str, str]
    lost: Mapping[str, Mask]
    moved: Float
    begins: Ints
    episodes: Sequence["Episode"]
    all_numbers: frozenset[int]
    notes: tuple[str, ...] = ()
    told_by: str = ""
    terms: Mapping[str, Mapping[str, Float]] = field(default_factory=dict)

    def __len__(self) -> int:
        return len(self.episodes)

    def each(self, what: str) -> NDArray[Any]:
        """Something of each episode, by its name, (episodes,)."""
        return np.array([getattr(it, what) for it in self.episodes])

    @property
    def known(self) -> Mask:
        """The episodes of which something says whether they succeeded, (episodes,)."""
        known: Mask = self.each("success") != UNKNOWN
        return known

    @property
    def succeeded(self) -> Mask:
        """Those that did."""
        succeeded: Mask = self.each("success") == SUCCESS
        return succeeded

    @property
    def steps(self) -> int:
        """How many steps there are."""
        return int(self.begins[-1])

    @cached_property
    def unpaid(self) -> Mapping[str, Mask]:
        """By reward, which episodes it does not pay the last step, for want of what was seen after it, (episodes,)."""
        return {name: np.isnan(values[self.begins[1:] - 1]) & ~self.lost[name] for name, values in self.paid.items()}

    @cached_property
    def returns(self) -> Mapping[str, Float]:
        """By reward, the sum over each episode, (episodes,), of all that it pays.

        Sums of float32 that differ by no more than their rounding are made equal: ten times 0.1 is 1.
        """
        paid = {name: np.nan_to_num(values) for name, values in self.paid.items()}
        sums = {name: self.summed(values) for name, values in paid.items()}
        rounding = {name: self.summed(_rounding(values)).max(initial=0.0) for name, values in paid.items()}
        return {name: _joined(values, rounding[name]) for name, values in sums.items()}

    @cached_property
    def still(self) -> Mask:
        """In which steps nothing happens, (steps,)."""
        seen = self.moved[np.isfinite(self.moved)]
        root = float(np.sqrt(np.mean(np.square(seen)))) if len(seen) else 0.0
        still: Mask = self.moved <= STILL * root
        return still

    def summed(self, values: Float) -> Float:
        """The sum over each episode, (episodes,), of a number of each step, (steps,)."""
        return sums_from(self.begins[:-1], values)

    def episode_steps(self, place: int) -> slice:
        """The steps of the episode in this place."""
        return slice(int(self.begins[place]), int(self.begins[place + 1]))


def _rounding(steps: Float) -> Float:
    """How far two numbers may be apart that were one before they became float32; 0 where they are no float32."""
    with np.errstate(over="ignore"):
        is_single = bool((steps == steps.astype(np.float32)).all()) and bool((steps != np.floor(steps)).any())
    return np.abs(steps) * (float(np.finfo(np.float32).eps) if is_single else 0.0)


def _joined(sums: Float, reach: float) -> Float:
    """The same, where neighbours that are no farther apart than `reach` have the value of the lowest."""
    if reach <= 0.0:
        return sums
    order = np.argsort(sums, kind="stable")
    begins = np.diff(sums[order], prepend=-np.inf) > reach
    joined = np.empty_like(sums)
    joined[order] = sums[order][begins][np.cumsum(begins) - 1]
    return joined


@dataclass(frozen=True)
class Labels:
    """What says from outside which episodes succeeded.

    Attributes:
        by_episode: `SUCCESS`, `FAILURE` or `UNKNOWN` by number of the episode; None if that is not what says it.
        above: The recorded return above which an episode is a success; None likewise.
    """

    by_episode: Mapping[int, int] | None = None
    above: float | None = None

    def of(self, episodes: Sequence["Episode"]) -> NDArray[np.int8]:
        """Labels of episodes."""
        if self.by_episode is not None:
            return np.array([self.by_episode.get(it.number, UNKNOWN) for it in episodes], np.int8)
        paid = np.array([it.recorded for it in episodes])
        return np.where(np.isnan(paid), UNKNOWN, np.where(paid > self.above, SUCCESS, FAILURE)).astype(np.int8)


def pay_dataset(
    dataset: Log, rewards: Mapping[str, Payer], places: "ArmPlaces | None" = None, labels: Labels | None = None
) -> PaidDataset:
    """Pay all steps of a data set, reading some at a time.

    A reward that fails is left out, and the reason is told; the others go on. An episode in which a number is not
    finite, or too large, is lost for those rewards that read it. One that equals another is left out.

    Args:
        dataset: It, a log of steps.
        rewards: By name.
        places: Where the end effector stands, by which a step is told from standing still; None to take all numbers of
            an observation.
        labels: What says which episodes succeeded; None where the data set does.

    Raises:
        SchemaError: The data set is damaged, or has no step, or more than 20 million.
        UsageError: The places are none of this data set.
    """
    kept, facts = _Kept(rewards), dataset_facts(dataset)
    movement = Movement(places)
    for rows in steps_by_episode(dataset, _columns(dataset, rewards, labels)):
        kept.steps += len(rows)
        if kept.steps > MOST_STEPS or len(kept.episodes) > MOST_EPISODES:
            raise SchemaError(
                f"{facts.path} has more than {MOST_STEPS:,} steps or {MOST_EPISODES:,} episodes, which is not allowed"
            )
        movement.take(rows, kept.take(rows))
    if not kept.steps:
        raise SchemaError(f"{facts.path} has no step")
    return kept.end(facts, movement.end(), labels)


def _columns(dataset: Log, rewards: Mapping[str, Payer], labels: Labels | None) -> Iterator[str]:
    """What is read: what the environment told only where a function may look at it."""
    functions = not all(isinstance(reward, Recorded) for reward in rewards.values())
    for name in dataset.names:
        if name.startswith(INFO) or name in ENDS:
            yield from [name] if functions else []
        elif name == LABEL:
            yield from [name] if labels is None else []
        elif name in (*DESCRIBING, SEEN) or name.startswith((REWARD, OBSERVATION, f"{BEFORE}{OBSERVATION}", ACTION)):
            yield name


LABEL = f"{BEHAVIOUR}{SUCCESS_NAME}"
UNSEEN = "it pays no step: it looks at what came after a step, and no episode tells that"
DESCRIBING = ("episode", "step", OPERATOR, TASK, FILE)


@dataclass
class Episode:
    """What is known of one so far.

    Attributes:
        number: In the data set.
        operator: Who made it; empty if nothing says it.
        file: Where it lies.
        begin: Number of its first step, among all that were read.
        content: A digest of it.
        tasks: What its steps do.
        recorded: What the data set's own reward pays it; NaN without one.
        last: What that pays its last step.
        success: `SUCCESS`, `FAILURE` or `UNKNOWN`.
        shown_last: Whether it is a success by its last step alone.
    """

    number: int
    operator: str
    file: str
    begin: int
    content: Fingerprint
    tasks: set[str] = field(default_factory=set)
    recorded: float = 0.0
    last: float = np.nan
    success: int = UNKNOWN
    shown_last: bool = False

    @property
    def task(self) -> str:
        """What it does; several tasks in the order of their names."""
        return " + ".join(sorted(self.tasks))


class _Kept:
    """What is kept of the steps."""

    def __init__(self, rewards: Mapping[str, Payer]) -> None:
        self._rewards = rewards
        self._paid: dict[str, list[Paid]] = {name: [] for name in rewards}
        self._failed: dict[str, str] = {}
        self._odd: dict[str, str] = {}
        self._lost: dict[str, set[int]] = {name: set() for name in rewards}
        self._told: list[Float] = []
        self.episodes: list[Episode] = []
        self.steps = 0

    def take(self, rows: Rows) -> int:
        """The next steps of an episode; of how many it is known what was seen after them."""
        columns = rows.columns
        if not self.episodes or self.episodes[-1].number != rows["episode"][0]:
            operator, file = (str(columns[name][0]) if name in columns else "" for name in (OPERATOR, FILE))
            begin = self.steps - len(rows)
            self.episodes.append(Episode(int(rows["episode"][0]), operator, file, begin, Fingerprint()))
        episode = self.episodes[-1]
        episode.tasks |= {*columns[TASK].tolist()} if TASK in columns else {""}
        self._told.append(columns[LABEL] if LABEL in columns else np.full(len(rows), np.nan))
        episode.content.take(rows)
        own = columns.get(f"{REWARD}{RECORDED}", np.full(1, np.nan))
        if not is_countable(own).all():
            own = np.full(1, np.nan)
        episode.recorded, episode.last = episode.recorded + episode_sum(own), float(own[-1])
        for name, reward in self._rewards.items():
            if name not in self._failed:
                self._pay(name, reward, rows, episode)
        return seen_after(rows)

    def _pay(self, name: str, reward: Payer, rows: Rows, episode: Episode) -> None:
        try:
            found = reward(rows)
            paid = np.array([found.total, *found.terms.values()], np.float64)
        except Unscored as error:
            self._failed[name] = f"episode {episode.number}: {error}"
            return
        except HarnessError:
            raise
        except (Exception, SystemExit) as error:  # a plugin may raise anything
            self._failed[name] = f"episode {episode.number}: {one_line(error)}"
            return
        fits = is_countable(paid).all(axis=0)
        if not fits.all():
            self._odd.setdefault(name, f"episode {episode.number}: ValueError: it pays {UNCOUNTABLE}")
            self._lost[name].add(len(self.episodes) - 1)
        rest = np.full(len(rows) - len(fits), np.nan)
        total, *terms = (np.append(np.where(fits, of, np.nan), rest) for of in paid)
        self._paid[name].append(Paid(total, dict(zip(found.terms, terms, strict=True))))

    def end(self, facts: DatasetFacts, moved: Float, labels: Labels | None) -> PaidDataset:
        """All of them, without what is left out."""
        begins = np.array([*(it.begin for it in self.episodes), self.steps], np.int64)
        success, shown_last = _told_of(np.concatenate(self._told), begins)
        if labels is not None:
            success = labels.of(self.episodes)
            shown_last = success == SUCCESS  # nobody says by which step
        chosen, notes = _choose(self.episodes, success, facts.pictures_left_out)
        steps = np.repeat(chosen, np.diff(begins))
        for it, told, last in zip(self.episodes, success.tolist(), shown_last.tolist(), strict=True):
            it.success, it.shown_last = told, last
        failed, lost, paid = {**self._failed}, dict[str, Mask](), dict[str, Paid]()
        for name, parts in self._paid.items():
            if name in self._failed:
                continue
            whole = _joined_pay(parts)
            nothing = np.logical_and.reduceat(np.isnan(whole.total), begins[:-1])
            gone = (nothing | np.isin(np.arange(len(nothing)), [*self._lost[name]]))[chosen]
            if gone.all():
                failed[name] = self._odd.get(name, UNSEEN)
            else:
                lost[name] = gone
                paid[name] = Paid(whole.total[steps], {term: of[steps] for term, of in whole.terms.items()})
        return PaidDataset(
            facts,
            {name: of.total for name, of in paid.items()},
            failed,
            lost,
            moved[steps],
            np.concatenate([[0], np.cumsum(np.diff(begins)[chosen])]).astype(np.int64),
            [it for it, stays in zip(self.episodes, chosen, strict=True) if stays],
            frozenset(it.number for it in self.episodes),
            notes,
            facts.told_by if labels is None else RECORDED if labels.above is not None else "",
            {name: of.terms for name, of in paid.items() if of.terms},
        )


def _joined_pay(parts: Sequence[Paid]) -> Paid:
    """What a reward paid in all parts; NaN for a term in those in which it was told of none."""
    names = dict.fromkeys(name for of in parts for name in of.terms)
    each = {name: [of.terms.get(name, np.full_like(of.total, np.nan)) for of in parts] for name in names}
    return Paid(np.concatenate([of.total for of in parts]), {name: np.concatenate(of) for name, of in each.items()})


def _told_of(told: Float, begins: Ints) -> tuple[NDArray[np.int8], Mask]:
    """Whether each episode succeeded, and whether its last step alone says so.

    A step that is a success makes the episode one. It is a failure if all steps from the first that is known are
    failures: labels may begin late, but they have no gap.
    """
    starts, ends = begins[:-1], begins[1:] - 1
    known, success = ~np.isnan(told), told == SUCCESS
    stops = np.zeros(len(told), np.int64)
    stops[:-1] = known[:-1] & ~known[1:]
    stops[ends] = 0
    successes = np.add.reduceat(success.astype(np.int64), starts)
    is_failure = known[ends] & (np.add.reduceat(stops, starts) == 0)
    found = np.where(successes > 0, SUCCESS, np.where(is_failure, FAILURE, UNKNOWN))
    return found.astype(np.int8), (successes == 1) & success[ends]


def _choose(
    episodes: list[Episode], success: NDArray[np.int8], pictures_left_out: bool
) -> tuple[Mask, tuple[str, ...]]:
    """Which episodes are used, and what is told of the others. Of equal ones the first is, with what any says.

    Two that differ in their pictures alone, which are left out, are equal by chance where all numbers are whole.
    """
    notes = []
    first: dict[bytes, int] = {}
    copies: list[tuple[int, int]] = []
    torn: set[int] = set()
    for place, episode in enumerate(episodes):
        if pictures_left_out and not episode.content.has_fractions:
            continue
        original = first.setdefault(episode.task.encode() + b"\0" + episode.content.digest(), place)
        if original != place:
            copies.append((place, original))
            both = {int(success[place]), int(success[original])}
            if both == {SUCCESS, FAILURE}:
                torn.add(original)
            success[original] = max(both)
    success[list(torn)] = UNKNOWN
    if copies:
        copy, original = (episodes[place].number for place in copies[0])
        equal = f"(episode {copy} is episode {original})"
        notes.append(f"Left out, since they equal another, which counts once: {_count(len(copies))} {equal}")
    if torn:
        numbers = ", ".join(str(episodes[place].number) for place in sorted(torn)[:5])
        notes.append(
            f"Equal episodes are a success here and a failure there; not known of: {_count(len(torn))} ({numbers})"
        )
    chosen = np.ones(len(episodes), bool)
    chosen[[place for place, _ in copies]] = False
    return chosen, tuple(notes)


def _count(number: int) -> str:
    return f"{number:,} {'episode' if number == 1 else 'episodes'}"

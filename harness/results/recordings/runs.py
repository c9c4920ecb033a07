"""Recorded trainings, their steps left in their files, and those that can be compared."""

import re
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np

from harness.arrays import Float
from harness.errors import Unscored, UsageError
from harness.eta.behaviour_change import Quantity
from harness.eta.interval import UNBOUNDED
from harness.eta.laws import Better, Missing, direction_of
from harness.eta.manner import EVALUATION, LAST_FIFTH, WHOLE
from harness.eta.rescaling import Rescaling, rescaling_of
from harness.log import Log, LogFacts
from harness.log.log import RECORDED, REWARD, SUCCESS
from harness.record.cell import BROUGHT
from harness.record.recording.facts import TrainingFacts, facts_of
from harness.registry.choice import Choice
from harness.results.by_term import ByTerm
from harness.results.comparison import Group
from harness.results.logs.told import RETURN, Deciding
from harness.results.metrics import Counted, Values
from harness.results.recordings.episodes import Did, Episodes, Part, can_be, episodes_of
from harness.results.recordings.recording_results import (
    Likeness,
    RecordingResults,
    likeness_of,
    terms_in,
)

NO_NAME = "an env without a name"
UNKNOWN = "a reward is not known in all trainings"


@dataclass(frozen=True, eq=False)
class LogPay:
    """The pay that a log tells; a recording that lies in files tells it as `RecordingResults`.

    Attributes:
        log: The log; its rows may be episodes or points.
    """

    log: Log

    def paid_by(self, reward: str) -> Float:
        """What a reward pays for each step, (steps,).

        Raises:
            Unscored: The log has no steps; says what it has.
        """
        facts = self.log.facts
        if facts.unit != "step":
            raise Unscored(f"'{facts.path}' tells {facts.unit}s, and not what was paid for each step")
        return self.log[f"{REWARD}{reward}"]

    def terms_paid(self, reward: str) -> ByTerm:
        """What each term of a reward paid; a log without steps tells none."""
        return terms_in(self.log, reward) if self.log.facts.unit == "step" else ByTerm({}, 0)


@dataclass(frozen=True, eq=False)
class Run(Did):
    """One training, its steps left in their files.

    Attributes:
        recorded: What was paid for its steps.
        facts: What is known beside its steps.
        seed: Of the training, or the number that it was given.
        steps: How many environment steps are recorded.
        episodes: All that ended.
        likeness: What its columns have in common.
        evaluation: Those of its final policy, where they were recorded.
        other: Those of its final policy that acted in the other manner.
        before: Evaluations before the training ended, in order.
        cut: How many of its steps are compared; 0 before that is known.
        random: Random actions in the same env, where they were recorded.
        apart: Why what two rewards paid is not compared; empty where it is.
    """

    recorded: RecordingResults | LogPay
    facts: TrainingFacts
    seed: int
    steps: int
    episodes: Episodes
    likeness: Likeness
    evaluation: "Run | None" = None
    other: "Run | None" = None
    before: tuple["Run", ...] = ()
    cut: int = 0
    random: "Run | None" = None
    apart: str = ""
    manifest = None
    has_terms = True

    @property
    def path(self) -> Path:
        """Its folder, or its file."""
        return self.facts.path

    @property
    def key(self) -> tuple[str, int]:
        """Its reward and its seed."""
        return self.reward, self.seed

    @property
    def everything(self) -> list["Run"]:
        """The training, and its evaluations."""
        return [it for it in (self, self.evaluation, self.other, *self.before) if it is not None]

    @property
    def reward(self) -> str:
        """The reward that it was trained with."""
        return self.facts.trained_with

    def parts(self, steps: int) -> dict[str, Part]:
        """By manner, the training cut to so many steps; what says most about its final policy comes first."""
        other = f"{EVALUATION}, {self.other.facts.acted}" if self.other else ""
        evaluated = {EVALUATION: self.evaluation, other: self.other}
        return {
            **{manner: run.whole for manner, run in evaluated.items() if run is not None},
            LAST_FIFTH: self.episodes.end(steps),
            WHOLE: self.episodes.part(0, steps),
        }

    @cached_property
    def _manners(self) -> Mapping[str, Part]:
        return self.parts(self.cut)

    @cached_property
    def _evaluated(self) -> Mapping[int, Part]:
        last = {} if self.evaluation is None else {self.cut: self.evaluation.whole}
        return {**{it.facts.after: it.whole for it in self.before}, **last}

    @property
    def _floor(self) -> Values:
        return dict(self.random.whole.behaviour) if self.random else {}

    @property
    def whole(self) -> Part:
        """All of its episodes."""
        return self.episodes.whole

    # What it was paid

    def paid(self, by: Any) -> Float:
        """What the reward of a training pays for each of its steps, (rows,)."""
        if by.reward not in self.facts.rewards or not self.episodes.knows(by.reward):
            raise Unscored(UNKNOWN)
        return self.recorded.paid_by(by.reward)

    def returned(self, by: Any, manner: str = EVALUATION, *, with_events: bool = False) -> float:
        """What the reward of a training pays one of its episodes of one manner, with all that is known of the pay."""
        if self.apart:
            raise Unscored(self.apart)
        part = self._manners.get(manner)
        value = part and part.returns.get(by.reward)
        if value is None:
            raise Unscored(self._why(by.reward, part))
        return value

    def random_pay(self) -> Float:
        """What its reward pays random actions, (episodes,)."""
        paid = None if self.random is None else self.random.episodes.returns.get(self.reward)
        if paid is None or np.isnan(paid).any():
            raise Unscored(UNKNOWN)
        return paid

    def at_random(self) -> Part | None:
        """What random actions come to; None where they are not known."""
        return self.random.whole if self.random else None

    def terms(self, by: Any, part: str) -> ByTerm | None:
        """What the terms of a training's reward pay its ``training``, its ``evaluation``, or ``random`` actions.

        None where that is not known, or not asked for.
        """
        of = {"training": self, "evaluation": self.evaluation, "random": self.random}[part]
        return None if of is None else of.recorded.terms_paid(by.reward)

    def _why(self, name: str, part: Part | None) -> str:
        return f"{name} in '{self.path}': {part.reasons.get(name, 'not recorded') if part else 'not evaluated'}"


def run_of(log: Log, seed: int, steps: int = 0, digest: str = "") -> Run:
    """The training of a log, whose facts tell the reward that paid it: what the log calls `RECORDED` is what it paid.

    Args:
        log: Its rows may be steps, which tell the rest.
        seed: Of the training.
        steps: How many there were.
        digest: Of its rows; see `Likeness`.

    Raises:
        SchemaError: It is damaged.
    """
    then, now = (f"{REWARD}{name}" for name in (RECORDED, log.facts.trained_with))
    terms = {f"{then}/{term}": f"{now}/{term}" for term in log.terms_of(RECORDED)}
    log = log.renamed({then: now, **terms}).without_starts()
    is_of_steps = log.facts.unit == "step"
    likeness = likeness_of(log) if is_of_steps else Likeness(digest)
    return Run(LogPay(log), facts_of(log), seed, len(log) if is_of_steps else steps, episodes_of(log), likeness)


def rescaling_between(runs: Iterable[Run], reward: str, other: str) -> Rescaling | None:
    """What a reward is of another one, by all trainings that know both; None if it is another one."""
    return rescaling_of(
        [
            run.likeness.line(other, reward)
            for run in runs
            if all(it in run.facts.rewards and run.episodes.knows(it) for it in (reward, other))
        ]
    )


def meet_same_starts(runs: Iterable[Run]) -> bool:
    """Whether policies met the same episodes in their evaluations, as far as the first observations tell."""
    found = {(len(it.episodes.last), it.facts.starts) for run in runs for it in run.everything if it.facts.starts}
    return len(found) == len({episodes for episodes, _ in found})


def brought(env: str, algorithm: Choice, steps: int, episodes: int = 0, every: int = 0) -> Group:
    """The group of trainings that no experiment made: as `Group` tells it."""
    simulator = BROUGHT.simulator
    return Group(BROUGHT.robot, Choice(env, (), env), algorithm, steps, episodes, every, simulator=simulator)


def better_of(measure: str, told: Sequence[LogFacts], deciding: Deciding, *, is_flag: bool = False) -> Better:
    """Which values of a measure are better, by what logs tell; what the user says of the one that decides counts more.

    Empty where nobody says it.
    """
    if deciding.better and measure == deciding.name:
        return deciding.better
    lower = {name for it in told for name in it.lower_is_better}
    higher = {name for it in told for name in it.higher_is_better}
    return direction_of(measure, lower, higher, is_flag=is_flag or measure in (SUCCESS, RETURN))


def quantities_of(
    names: Iterable[str], runs: Collection[Run], told: Sequence[LogFacts], deciding: Deciding
) -> dict[str, Quantity]:
    """What measures are, by name.

    A share is 0 or 1 in every episode. Bounds are what the recordings say, if they agree; see `can_be`.
    """
    everybody = [it for run in runs for it in run.everything]
    found = {}
    for name in names:
        is_flag = all(it.episodes.is_flag(name) for it in everybody)
        said = {run.facts.bounds.get(name, UNBOUNDED) for run in runs}
        bounds = can_be(name, [it.episodes for it in everybody], said.pop() if len(said) == 1 else UNBOUNDED)
        better = better_of(name, told, deciding, is_flag=is_flag)
        found[name] = Quantity(name, "", better, "", 1 if is_flag else None, bounds=bounds)
    return found


def called_alike(folder: Path, read: Collection[Path], rewards: Iterable[str], seen: Iterable[Path]) -> list[Path]:
    """Files and folders that are called as trainings are, but for numbers and names of rewards, and are none.

    Args:
        folder: Where they lie.
        read: Files or folders of trainings, whose own folders count too.
        rewards: The names of the rewards that taught them.
        seen: What else is known of, and not looked for.
    """
    words = re.compile(f"({'|'.join(map(re.escape, sorted(rewards, key=len, reverse=True)))})|[0-9]+")

    def shape(path: Path) -> str:
        return words.sub(lambda word: "reward" if word[1] else "0", path.relative_to(folder).as_posix())

    named = {shape(it) for path in read for it in (path, *path.parents) if it.is_relative_to(folder)}
    full = {it for path in (*read, *seen) for it in (path, *path.parents)}
    found = dict[Path, None]()
    for path in sorted(folder.rglob("*")):
        if path not in full and shape(path) in named and found.keys().isdisjoint(path.parents):
            found[path] = None
    return [*found]


DIRECTION = "say --measure {0}:better=lower or --measure {0}:better=higher"
"""What to type for a measure that decides and has no direction."""


def require_one(told: Iterable[tuple[str, str]], problem: str, remedy: str) -> str:
    """The one value that all trainings tell; empty where none tells it.

    Args:
        told: Each value that is told, with the training that tells it.
        problem: What to say of several.
        remedy: What to do then.

    Raises:
        UsageError: They tell several.
    """
    found = dict[str, str]()
    for value, where in told:
        found.setdefault(value, where)
    found.pop("", None)
    if len(found) > 1:
        raise UsageError(f"{problem}: {', '.join(f'{value} ({where})' for value, where in found.items())}. {remedy}")
    return next(iter(found), "")


class Runs(NamedTuple):
    """Trainings in one env that can be compared."""

    group: Group
    """What all of them share; of loose recordings, as far as it is known."""
    rewards: tuple[str, ...]
    """The rewards that scored them, in the order that they were given in; of those that taught, the baseline first."""
    quantities: Mapping[str, Quantity]
    """The measures of behaviour, in the order that they were given in; the first one decides."""
    members: Mapping[tuple[str, int], Run]
    """By reward and seed."""
    steps: int
    """The steps of the shortest: all are cut to it."""
    notes: tuple[str, ...]
    """What to keep in mind, a line each."""
    damaged: tuple[str, ...] = ()
    """What could not be read, a line each."""
    control: Mapping[int, Run] = MappingProxyType({})
    """Trainings by the baseline again with other seeds, each by the seed that it is compared with."""
    said: tuple[str, ...] = ()
    """How what was found was sorted and read, a line each; a reader has to know it before the first number."""
    counted: Mapping[str, Counted] = MappingProxyType({})
    """By manner, what stands for episodes: a log of curves has a ``point``, which is a mean over some."""
    missing: tuple[Missing, ...] = ()
    """Trainings that were begun and have no value: no test is made without them."""
    offered: tuple[str, ...] = ()
    """The measures that could have been named to decide, where the one that does was named after they were known."""

    @property
    def trained(self) -> list[str]:
        """The rewards that taught a policy; the first one is the baseline."""
        return [name for name in self.rewards if any(name == reward for reward, _ in self.members)]

    @property
    def measures(self) -> tuple[str, ...]:
        """The names of the measures of behaviour."""
        return tuple(self.quantities)

    def measure(self, name: str, manner: str, episodes: int) -> Quantity:
        """What a measure is in the episodes of one manner, of which each seed has `episodes` at least."""
        of = self.quantities[name]
        return of._replace(manner=manner, episodes=of.episodes and episodes)

"""What a run found of speeds, how it is kept, and what became slower between two runs, beyond the noise of both.

Speeds are ratios against what was timed beside them, so that a faster machine does not make a plugin faster.
"""

import math
import statistics
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from functools import cached_property
from pathlib import Path
from typing import Annotated, Any, NamedTuple

import numpy as np
from pydantic import Field, TypeAdapter, ValidationError
from scipy.stats import t as student

from harness.authoring.commands import read_json
from harness.errors import NewerFormat, SchemaError

from .contests import Entry, Round, Setting

FORMAT = 1
MOST_BYTES = 8 * 2**20
"""The most bytes of a file; one of a thousand entries has two."""
REMEDY = "Give a file that 'harness bench simulators --json' wrote, or one of algorithms or peers"


class Spread(NamedTuple):
    """Several rounds' numbers: what lies in the middle, and between which the middle half lies."""

    median: float
    low: float
    """First quartile."""
    high: float
    """Third quartile."""


def spread_of(values: Sequence[float]) -> Spread:
    """Median and quartiles of at least one value."""
    if len(values) == 1:
        return Spread(values[0], values[0], values[0])
    low, middle, high = statistics.quantiles(values, n=4, method="inclusive")
    return Spread(middle, low, high)


class Reason(NamedTuple):
    """Why an entry, called by its title, has no numbers."""

    name: str
    reason: str


@dataclass(frozen=True)
class Speed:
    """One entry, over all rounds.

    Attributes:
        entry: What was timed.
        rounds: At least one.
    """

    entry: Entry
    rounds: Annotated[tuple[Round, ...], Field(min_length=1, max_length=1000)]

    def __post_init__(self) -> None:
        """Every round has the same contenders."""
        if len({(frozenset(one.seconds), frozenset(one.speeds)) for one in self.rounds}) > 1:
            raise ValueError("rounds of one entry name different contenders")

    @cached_property
    def seconds(self) -> dict[str, float]:
        """The time of an environment step, by contender the median over the rounds, [s]."""
        return {name: statistics.median(one.seconds[name] for one in self.rounds) for name in self.rounds[0].seconds}

    @cached_property
    def speeds(self) -> dict[str, tuple[float, ...]]:
        """By contender how many times as fast as the reference, in each round; empty where there is no reference."""
        return {name: tuple(one.speeds[name] for one in self.rounds) for name in self.rounds[0].speeds}

    @property
    def reference(self) -> str:
        """What the others were measured against; empty where there is nothing."""
        return next((name for name in self.seconds if name not in self.speeds), "") if self.speeds else ""

    def to_json(self) -> dict[str, Any]:
        """Plain data."""
        return {
            "entry": asdict(self.entry),
            "title": self.entry.title,
            "reference": self.reference,
            "seconds_per_step": self.seconds,
            "speeds": {name: spread_of(values)._asdict() for name, values in self.speeds.items()},
            "rounds": [asdict(one) for one in self.rounds],
        }


@dataclass(frozen=True)
class Speeds:
    """What was measured.

    Attributes:
        rounds: How many processes timed each entry, taking turns.
        setting: What all entries had in common.
        speeds: Of the entries that worked.
        failed: Titles of those that did not, each with the reason.
        left_out: Titles of those that cannot be timed here, each with the reason.
        cpu: What it was measured on.
        versions: Of Python and of the distributions that the results depend on.
    """

    rounds: Annotated[int, Field(gt=0)]
    setting: Setting
    speeds: tuple[Speed, ...]
    failed: tuple[Reason, ...]
    left_out: tuple[Reason, ...]
    cpu: str
    versions: Mapping[str, str]

    def to_json(self) -> dict[str, Any]:
        """Plain data; `read_speeds` gives the same back."""
        return {
            "format": FORMAT,
            "what": "speeds",
            "rounds": self.rounds,
            "cpu": self.cpu,
            "versions": dict(self.versions),
            "setting": asdict(self.setting),
            "speeds": [speed.to_json() for speed in self.speeds],
            "failed": [reason._asdict() for reason in self.failed],
            "left_out": [reason._asdict() for reason in self.left_out],
        }


FORM: TypeAdapter[Speeds] = TypeAdapter(Speeds)


def read_speeds(path: Path) -> Speeds:
    """What ``harness bench ... --json`` wrote.

    Raises:
        NewerFormat: A newer version did.
        SchemaError: It is something else, or damaged.
        OSError: It cannot be read.
    """
    try:
        data = read_json(path, MOST_BYTES)
    except ValueError as error:
        raise SchemaError(f"'{path}' is no JSON: {error}. {REMEDY}") from error
    if not isinstance(data, dict) or data.get("what") != "speeds":
        raise SchemaError(f"'{path}' holds no speeds. {REMEDY}")
    if data.get("format") != FORMAT:
        raise NewerFormat(f"'{path}' has format {data.get('format')}, this version reads {FORMAT}: use a newer harness")
    try:
        return FORM.validate_python(data)
    except ValidationError as error:
        first = error.errors()[0]
        place = ".".join(map(str, first["loc"]))
        raise SchemaError(f"'{path}' is not what the harness wrote: {place}: {first['msg']}") from error


FEWEST_ROUNDS = 3
"""With fewer, noise cannot be told."""
FLOOR = math.log(1.1)
"""A change of less than so much is none, however small the noise within the runs: what else the machine did moved the
ratios of the same code by up to 7 % from run to run."""
FALSE_ALARMS = 1e-3
"""How likely it is that noise alone makes a comparison of the same code complain of anything."""


@dataclass(frozen=True)
class Change:
    """One contender in both runs.

    Attributes:
        title: Of the entry.
        contender: Which one of it.
        reference: What it was timed beside.
        old: Its speeds in the earlier run, one per round.
        new: The same now.
        lines: How many contenders are compared; the more there are, the more it takes to complain of one.
    """

    title: str
    contender: str
    reference: str
    old: tuple[float, ...]
    new: tuple[float, ...]
    lines: int

    @cached_property
    def ratio(self) -> float:
        """How many times as fast it is as it was: of the geometric means over the rounds."""
        return float(np.exp(np.log(self.new).mean() - np.log(self.old).mean()))

    @cached_property
    def noise(self) -> float:
        """The ratio that noise alone stays above: what is below it became slower.

        exp(-margin), where the margin is t s sqrt(1/n + 1/m), but at least `FLOOR`. s is the standard deviation of the
        logarithms of both runs' rounds about their own means, t Student's quantile for `FALSE_ALARMS` shared by all
        lines.
        """
        logs = [np.log(self.old), np.log(self.new)]
        freedom = sum(map(len, logs)) - 2
        variance = sum(float(((each - each.mean()) ** 2).sum()) for each in logs) / freedom
        spread = math.sqrt(variance * sum(1.0 / len(each) for each in logs))
        quantile = float(student.ppf(1.0 - FALSE_ALARMS / self.lines, freedom))
        return math.exp(-max(FLOOR, quantile * spread))

    @property
    def is_slower(self) -> bool:
        """Whether it became slower beyond the noise."""
        return self.ratio < self.noise

    @property
    def is_faster(self) -> bool:
        """Whether it became faster beyond the noise."""
        return self.ratio > 1.0 / self.noise

    def to_json(self) -> dict[str, Any]:
        """Plain data."""
        return {
            "title": self.title,
            "contender": self.contender,
            "reference": self.reference,
            "old": float(np.median(self.old)),
            "new": float(np.median(self.new)),
            "ratio": self.ratio,
            "noise": self.noise,
            "is_slower": self.is_slower,
            "is_faster": self.is_faster,
        }


@dataclass(frozen=True)
class SpeedChanges:
    """What two runs of the same timings differ in.

    Attributes:
        changes: Of every contender that both have, in the order of the new run.
        missing: Titles of entries that only the old run has: they failed, or cannot be timed here.
        remarks: What differs between the runs beside the plugins: machine, versions, settings.
    """

    changes: tuple[Change, ...]
    missing: tuple[str, ...]
    remarks: tuple[str, ...]

    @property
    def slower(self) -> tuple[Change, ...]:
        """What became slower beyond the noise."""
        return tuple(change for change in self.changes if change.is_slower)

    def to_json(self) -> dict[str, Any]:
        """Plain data."""
        return {
            "changes": [change.to_json() for change in self.changes],
            "slower": len(self.slower),
            "missing": list(self.missing),
            "remarks": list(self.remarks),
        }


def compare_speeds(old: Speeds, new: Speeds) -> SpeedChanges:
    """What changed from `old` to `new`; entries with fewer than `FEWEST_ROUNDS` rounds are not judged."""
    before = {speed.entry: speed for speed in old.speeds if len(speed.rounds) >= FEWEST_ROUNDS}
    pairs = [
        (before[speed.entry], speed)
        for speed in new.speeds
        if speed.entry in before and len(speed.rounds) >= FEWEST_ROUNDS
    ]
    lines = sum(len(_shared(*pair)) for pair in pairs)
    now = {speed.entry for speed in new.speeds}
    return SpeedChanges(
        changes=tuple(change for pair in pairs for change in _changes(*pair, lines)),
        missing=tuple(speed.entry.title for speed in old.speeds if speed.entry not in now),
        remarks=tuple(_remarks(old, new)),
    )


def _shared(old: Speed, new: Speed) -> list[str]:
    return [name for name in new.speeds if name in old.speeds]


def _changes(old: Speed, new: Speed, lines: int) -> Iterator[Change]:
    for name in _shared(old, new):
        yield Change(new.entry.title, name, new.reference, old.speeds[name], new.speeds[name], lines)


def _remarks(old: Speeds, new: Speeds) -> Iterator[str]:
    if old.cpu != new.cpu:
        yield f"The machines differ: {old.cpu} before, {new.cpu} now. The ratios of two machines differ by themselves."
    if old.setting != new.setting:
        yield f"The settings differ: {_text(asdict(old.setting))} before, {_text(asdict(new.setting))} now."
    for name in sorted({*old.versions, *new.versions}):
        before, now = old.versions.get(name, "none"), new.versions.get(name, "none")
        if before != now:
            yield f"The versions of {name} differ: {before} before, {now} now."
    few = [run.rounds for run in (old, new) if run.rounds < FEWEST_ROUNDS]
    if few:
        plural = "s" if min(few) > 1 else ""
        yield f"A run of {min(few)} round{plural} does not tell its noise: it takes {FEWEST_ROUNDS}."


def _text(values: dict[str, Any]) -> str:
    return ", ".join(f"{key} {value}" for key, value in values.items())


def described(change: Change) -> str:
    """A sentence about a change: by how much, and how much noise explains."""
    share = abs(change.ratio - 1.0)
    word = "slower" if change.ratio < 1.0 else "faster"
    margin = 1.0 - change.noise
    return (
        f"{change.title}: {change.contender} is {share:.0%} {word} beside the {change.reference} than it was "
        f"(noise explains up to {margin:.0%})"
    )


def summary(comparison: SpeedChanges) -> Sequence[str]:
    """What to say first: what became slower, or that nothing did."""
    if not comparison.changes:
        return ["Nothing could be compared."]
    slower = [f"SLOWER  {described(change)}" for change in comparison.slower]
    faster = [f"faster  {described(change)}" for change in comparison.changes if change.is_faster]
    return [*(slower or [f"Nothing of {len(comparison.changes)} became slower beyond the noise."]), *faster]

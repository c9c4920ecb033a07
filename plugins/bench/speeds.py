"""What a run found of speeds, and how it is kept."""

import statistics
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Annotated, Any, NamedTuple, Self

from pydantic import BaseModel, Field, ValidationError, model_validator

from harness.authoring.commands import read_json
from harness.errors import NewerFormat, SchemaError

from .contest import Round
from .entry import Entry, Setting

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


@dataclass(frozen=True)
class Speed:
    """One entry, over all rounds.

    Attributes:
        entry: What was timed.
        rounds: At least one.
    """

    entry: Entry
    rounds: tuple[Round, ...]

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
            "entry": self.entry.to_json(),
            "title": self.entry.title,
            "reference": self.reference,
            "seconds_per_step": self.seconds,
            "speeds": {name: spread_of(values)._asdict() for name, values in self.speeds.items()},
            "rounds": [{"seconds": dict(one.seconds), "speeds": dict(one.speeds)} for one in self.rounds],
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

    rounds: int
    setting: Setting
    speeds: tuple[Speed, ...]
    failed: tuple[tuple[str, str], ...]
    left_out: tuple[tuple[str, str], ...]
    cpu: str
    versions: Mapping[str, str]

    def to_json(self) -> dict[str, Any]:
        """Plain data; `speeds_from_json` gives the same back."""
        return {
            "format": FORMAT,
            "what": "speeds",
            "rounds": self.rounds,
            "cpu": self.cpu,
            "versions": dict(self.versions),
            "setting": self.setting.to_json(),
            "speeds": [speed.to_json() for speed in self.speeds],
            "failed": _reasons(self.failed),
            "left_out": _reasons(self.left_out),
        }


Number = Annotated[float, Field(gt=0, allow_inf_nan=False)]


class _Round(BaseModel):
    seconds: dict[str, Number]
    speeds: dict[str, Number]


class _Speed(BaseModel):
    entry: Entry
    rounds: Annotated[list[_Round], Field(min_length=1, max_length=1000)]

    @model_validator(mode="after")
    def _is_complete(self) -> Self:
        """Every round has the same contenders."""
        first = self.rounds[0]
        if any(
            one.seconds.keys() != first.seconds.keys() or one.speeds.keys() != first.speeds.keys()
            for one in self.rounds
        ):
            raise ValueError("rounds of one entry name different contenders")
        return self


class _Reason(BaseModel):
    name: str
    reason: str


class _Speeds(BaseModel):
    rounds: Annotated[int, Field(gt=0)]
    cpu: str
    versions: dict[str, str]
    setting: Setting
    speeds: list[_Speed]
    failed: list[_Reason]
    left_out: list[_Reason]


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
    return _from_json(data, path)


def _from_json(data: dict[str, Any], path: Path) -> Speeds:
    try:
        told = _Speeds.model_validate(data)
        return Speeds(
            rounds=told.rounds,
            setting=told.setting,
            speeds=tuple(
                Speed(each.entry, tuple(Round(one.seconds, one.speeds) for one in each.rounds)) for each in told.speeds
            ),
            failed=tuple((each.name, each.reason) for each in told.failed),
            left_out=tuple((each.name, each.reason) for each in told.left_out),
            cpu=told.cpu,
            versions=told.versions,
        )
    except ValidationError as error:
        first = error.errors()[0]
        place = ".".join(map(str, first["loc"]))
        raise SchemaError(f"'{path}' is not what the harness wrote: {place}: {first['msg']}") from error


def _reasons(told: Sequence[tuple[str, str]]) -> list[dict[str, str]]:
    return [{"name": name, "reason": reason} for name, reason in told]

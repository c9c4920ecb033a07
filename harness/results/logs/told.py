"""What a user says of logs; everything else is found out."""

import math
from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple

from harness.errors import UsageError
from harness.eta.interval import Bounds
from harness.eta.laws import Better
from harness.registry.choice import parse

RETURN, LENGTH = "return", "length"
"""Measures that every log of episodes has, if the user says that they decide."""


class Deciding(NamedTuple):
    """What decides about the policies, as the user says it.

    Attributes:
        name: A measure of the logs; ``length`` of the episodes; ``return``, if one and the same reward paid all logs.
        better: ``higher`` or ``lower``; empty where the measure itself tells.
    """

    name: str = ""
    better: Better = ""


SUCCESS_DECIDES = Deciding()


@dataclass(frozen=True)
class Told:
    """What a user says of logs. Everything else is found out.

    Attributes:
        format: The format with its settings, ``table:success=is_success``.
        sort: How names are made, ``{reward}/{seed}``.
        baseline: The reward that the others are compared with.
        deciding: What decides.
        labels: A file that says which trainings, or episodes, were successes.
        leave_out: Files and folders of trainings that are left out.
        per_step: How many environment steps an iteration of each reward is, ``base=98304,prop=49152``.
        ends: By measure, the least and the greatest value that a training can have.
    """

    format: str = ""
    sort: str = ""
    baseline: str = ""
    deciding: Deciding = SUCCESS_DECIDES
    labels: Path | None = None
    leave_out: tuple[Path, ...] = ()
    per_step: str = ""
    ends: Mapping[str, Bounds] = field(default_factory=dict)

    def steps_of(self, rewards: Collection[str]) -> dict[str, int]:
        """How many environment steps an iteration of each reward is.

        Raises:
            UsageError: It is malformed, or says nothing of a reward.
        """
        pairs = [it.rpartition("=") for it in self.per_step.split(",") if it]
        found = {name: int(number) for name, _, number in pairs if number.isdecimal() and int(number)}
        if len(found) < len(pairs) or found.keys() != {*rewards}:
            each = ",".join(f"{name}=N" for name in rewards)
            raise UsageError(f"'{self.per_step}' does not say it of each reward: --per-step {each} does, N above 0")
        return found


FOUND_OUT = Told()


def parse_ends(texts: Iterable[str]) -> dict[str, Bounds]:
    """What ``--ends`` says: ``score=0,200``.

    Raises:
        UsageError: It is malformed.
    """
    found = {}
    for text in texts:
        name, _, ends = text.rpartition("=")
        try:
            low, high = map(float, ends.split(","))
        except ValueError:
            low = high = 0.0
        if not name or name in found or not -math.inf < low < high < math.inf:
            raise UsageError(
                f"--ends {text}: write NAME=LEAST,GREATEST, two numbers, the lower one first and no percentages, once "
                "for a measure, such as score=0,200"
            )
        found[name] = (low, high)
    return found


def parse_deciding(text: str) -> Deciding:
    """What ``--measure`` says of logs: ``success``, ``length:better=lower``.

    Raises:
        UsageError: It is malformed.
    """
    name, params = parse(text) if text else ("", {})
    better = params.pop("better", "")
    if params or better not in ("", "higher", "lower"):
        raise UsageError(f"--measure {text}: write NAME, NAME:better=higher or NAME:better=lower")
    return Deciding(name, better)  # type: ignore[arg-type] # one of these

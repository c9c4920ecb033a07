"""What a search says of one reward: one of four answers, whether it is a knife's edge, and what it rests on."""

# ruff: noqa: PLC0414 -- `X as X` tells type checkers that the name is public

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from harness.experiment.screening import (
    CANNOT_TELL as CANNOT_TELL,
    FAILING as FAILING,
    LOITERING as LOITERING,
    NOTHING as NOTHING,
)
from harness.files.plain import Plain, tells, to_plain

from .behaviour import Behaviour, Role, Searched
from .world import Shown

NAMES: Mapping[Role, str] = {
    "fastest": "fastest success", "failure": "best-paid failure", "success": "best-paid success"
}  # fmt: skip
"""What each behaviour is called, in the order in which they are shown: doing the task first."""


@dataclass(frozen=True)
class Disturbed:
    """What a behaviour was paid while its actions were disturbed.

    Attributes:
        role: Which behaviour.
        noise: The standard deviation of what is added to actions, as a share of half their range; of choices, the
            chance that another one is taken.
        paid: The mean over disturbed episodes.
        success: The share of them that succeeded.
        episodes: How many.
    """

    role: Role
    noise: float
    paid: float
    success: float
    episodes: int


@tells(
    "world",
    "reward",
    "gamma",
    "success_told_by=success",
    "answer=word",
    "strength",
    "lines",
    "starts",
    "alarmed",
    "steps=searched.steps",
    "searched_by=searched.how",
    "shown=three",
    "noise",
    "elsewhere",
    "random=searched.typical",
    "successes=searched.successes",
)
@dataclass(frozen=True, eq=False)
class Finding(Plain):
    """What a search says of one reward in one world.

    Attributes:
        world: Its name.
        reward: The label of the reward.
        gamma: The learner's discount per step.
        success: What tells success; empty if nothing does.
        word: The answer, one of the four.
        strength: ``ROBUST`` or ``FRAGILE`` beside an alarm; else empty.
        lines: The answer in sentences; the first one says the three numbers.
        alarmed: The starts where the alarm holds.
        starts: All that were searched.
        searched: What it rests on.
        noise: The curve of noise for the shown behaviours.
        elsewhere: By the name of another simulator, what the shown behaviours are paid there, by role.
        shown: The three behaviours of one start, the one that tells most; roles that were not found are left out.
        three: The same as they were found.
    """

    world: str
    reward: str
    gamma: float
    success: str
    word: str
    strength: str
    lines: tuple[str, ...]
    alarmed: tuple[int, ...]
    starts: tuple[int, ...]
    searched: Searched
    noise: tuple[Disturbed, ...]
    elsewhere: Mapping[str, Mapping[Role, float]]
    shown: Mapping[Role, Shown]
    three: Mapping[Role, Behaviour]

    def to_json(self) -> dict[str, Any]:
        """Plain data, finite numbers only; actions are in certificates."""
        found = {"plain": self.searched.plain, "discounted": self.searched.discounted}
        return {**super().to_json(), "found": to_plain(found)}

"""Where an arm's end effector and its target stand in a vector of numbers, and what an arm's reward pays from that.

The rewards of this project are functions of the distance from the end effector to the target. A log, or an environment
of anybody, has that distance only inside its observations. A map says where::

    end_effector=0:3,target=3:6                       numbers 0 to 2 and 3 to 5 of the observation, in metres
    end_effector=achieved_goal,target=desired_goal    parts of an observation that is a table
    end_effector=state[7:10],target=0.3/0.1/0.2       a stretch of a part, and a target that always is the same
    joints=0:6,target=6:9                             joint positions [rad]; `joints_deg` has them in degrees
    distance=17:18                                    the distance itself, [m], where positions are not observed
    distance=17:18,renewed=8:11                       numbers that change when a new target is drawn, and only then

Of joints a function gives the end effector, such as the forward kinematics of a robot. This module knows no files, no
robots and no environments.
"""

import re
from collections.abc import Callable, Collection, Mapping
from contextlib import suppress
from dataclasses import dataclass
from typing import Any

import numpy as np

from harness.arrays import Float, Mask
from harness.errors import UsageError
from harness.reward import Paid, Reward
from harness.reward.row_steps import DISTANCES
from harness.reward.terms import needs_of
from harness.score.scorer import Scorer, fields_beside_distances

NAMES = END_EFFECTOR, TARGET, JOINTS, JOINTS_DEG, DISTANCE, RENEWED = (
    "end_effector",
    "target",
    "joints",
    "joints_deg",
    "distance",
    "renewed",
)
ARM = (END_EFFECTOR, JOINTS, JOINTS_DEG)
MOST_PLACE = 1_000_000
EXAMPLE = "end_effector=0:3,target=3:6"
_PART = r"(?P<key>[^\[\]:/=,]+?)\s*(?:\[(?P<a>\d{1,9}):(?P<b>\d{1,9})\])?"
_PLACE = re.compile(rf"{_PART}|(?P<c>\d{{1,9}}):(?P<d>\d{{1,9}})")

Forward = Callable[[Float], Float]
"""From joint positions, (n, joints), [rad], to the end effector, (n, 3), [m]."""


@dataclass(frozen=True)
class Place:
    """Some numbers of a vector.

    Attributes:
        text: As a user typed it.
        key: The part that they stand in, of a vector that is a table of parts; empty if it is none.
        start: The first of them, counted from 0.
        stop: Behind the last; None for all that follow.
        constant: Numbers that stand in no vector; empty if they do.
    """

    text: str
    key: str = ""
    start: int = 0
    stop: int | None = None
    constant: tuple[float, ...] = ()

    def rows(self, vectors: Any) -> Float:
        """These numbers of each vector, (n, size), of vectors (n, width), or of a table of such by key.

        Raises:
            UsageError: The vectors have no such part, or too few numbers.
        """
        parts = vectors if isinstance(vectors, Mapping) else {"": vectors}
        if self.constant:
            return np.broadcast_to(self.constant, (len(next(iter(parts.values()))), len(self.constant)))
        if self.key not in parts:
            told = f"no part of a vector that has {', '.join(map(str, parts))}"
            none = "a part of a vector that has none: write numbers, such as 0:3"
            raise UsageError(f"{self.text} names {none if '' in parts else told}")
        part = parts[self.key]
        flat = np.asarray(part, np.float64).reshape(len(part), -1)
        stop = flat.shape[1] if self.stop is None else self.stop
        if stop > flat.shape[1] or self.start >= stop:
            raise UsageError(f"{self.text} is beyond the {flat.shape[1]} numbers that there are")
        return flat[:, self.start : stop]


@dataclass(frozen=True)
class ArmPlaces:
    """Where the end effector and the target stand.

    Attributes:
        places: `Place` by name: ``target`` and one that says where the end effector is, or ``distance``. Besides them
            ``renewed``, if a new target may be drawn inside an episode.
        forward: Where the end effector is if joints are given.
    """

    places: Mapping[str, Place]
    forward: Forward | None = None

    def end_effector(self, vectors: Any) -> Float:
        """Positions, (n, 3), [m].

        Raises:
            UsageError: As `Place.rows`; or there are other than three numbers.
        """
        name = next((it for it in ARM if it in self.places), END_EFFECTOR)
        found = self._rows(name, vectors)
        if name != END_EFFECTOR:
            if self.forward is None:
                raise UsageError(f"{name} says where joints stand; name the robot that they belong to")
            found = self.forward(np.deg2rad(found) if name == JOINTS_DEG else found)
        return _sized(found, END_EFFECTOR, 3)

    def target(self, vectors: Any) -> Float:
        """The same of the target."""
        return _sized(self._rows(TARGET, vectors), TARGET, 3)

    def distances(self, vectors: Any) -> Float:
        """From end effector to target, (n,), [m]."""
        if TARGET in self.places:
            return self.reached(vectors, vectors)
        return _sized(self.places[DISTANCE].rows(vectors), DISTANCE, 1)[:, 0]

    def fields(self, vectors: Any, names: Collection[str]) -> dict[str, Float]:
        """Those of ``end_effector``, ``target``, ``qpos`` that are asked for and that the map tells, (n, size) each."""
        ways = {END_EFFECTOR: self.end_effector, TARGET: self.target} if TARGET in self.places else {}
        if JOINTS in self.places:
            ways["qpos"] = self.places[JOINTS].rows
        return {name: way(vectors) for name, way in ways.items() if name in names}

    def reached(self, before: Any, after: Any) -> Float:
        """How far the end effector is after steps from the targets before them, (n,), [m].

        That is asked where a new target was drawn. A map of the distance alone cannot tell, and 0 is taken.
        """
        if TARGET not in self.places:
            return np.zeros(len(self.distances(after)))
        far: Float = np.linalg.norm(self.end_effector(after) - self.target(before), axis=1)
        return far

    def has_new_target(self, before: Any, after: Any) -> Mask:
        """Whether another target was drawn in each step, (n,); never if the map does not say what tells."""
        if RENEWED not in self.places:
            return np.zeros(len(self.distances(after)), bool)
        one, other = self.places[RENEWED].rows(before), self.places[RENEWED].rows(after)
        changed: Mask = (one != other).any(axis=1)
        return changed

    def _rows(self, name: str, vectors: Any) -> Float:
        if name not in self.places:
            raise UsageError(f"positions are needed, and the map has the distance alone: give them, as in {EXAMPLE}")
        return self.places[name].rows(vectors)


def parse_places(text: str, forward: Forward | None = None) -> ArmPlaces:
    """What a user typed, such as ``end_effector=0:3,target=3:6``.

    Args:
        text: Names and places, separated by commas.
        forward: From joints to the end effector, if the map names joints.

    Raises:
        UsageError: A name or a place is none, stands twice or is missing.
    """
    found: dict[str, Place] = {}
    for item in filter(None, (part.strip() for part in text.split(","))):
        name, _, where = (part.strip() for part in item.partition("="))
        if name not in NAMES or name in found or not where:
            raise UsageError(f"'{item}' in '{text}': give each of {', '.join(NAMES)} once at most, as in {EXAMPLE}")
        found[name] = parse_place(where)
    arms = [name for name in ARM if name in found]
    if (TARGET in found, len(arms), DISTANCE in found) not in ((True, 1, False), (False, 0, True)):
        raise UsageError(
            f"'{text}': name target and one of end_effector, joints and joints_deg, as in {EXAMPLE}; or distance alone"
        )
    return ArmPlaces(found, forward)


def parse_place(text: str) -> Place:
    """One place: ``0:3``, ``achieved_goal``, ``state[7:10]``, or a constant ``0.3/0.1/0.2``.

    Raises:
        UsageError: It is none.
    """
    with suppress(ValueError):
        numbers = tuple(map(float, text.split("/")))
        if len(numbers) == 3 and np.isfinite(numbers).all():
            return Place(text, constant=numbers)
    if match := _PLACE.fullmatch(text):
        key, start, stop = match["key"] or "", match["a"] or match["c"], match["b"] or match["d"]
        if start is None:
            return Place(text, key)
        if int(start) < int(stop) <= MOST_PLACE:
            return Place(text, key, int(start), int(stop))
    raise UsageError(
        f"'{text}' is no place: write 0:3, where the first number is below the second, {MOST_PLACE:,} at most; "
        "a part's name, or name[0:3]; or three numbers in metres, 0.3/0.1/0.2"
    )


def fields_read(reward: Reward) -> tuple[str, ...]:
    """What an arm's reward reads beside distances; nothing of one that fails on made-up steps."""
    with suppress(UsageError):
        return fields_beside_distances(needs_of(reward).fields)
    return ()


class ArmPay:
    """Pays one episode after another by an arm's reward, as many steps at a time as one likes."""

    def __init__(self, reward: Reward) -> None:
        self._reward = reward
        self._scorer = Scorer(reward)
        self._begin = self._best = float("nan")

    def begin(self, distance: float, more: Mapping[str, Float] = {}) -> None:
        """Start an episode at this distance, [m], and with these other fields that the reward reads, (1, size) each."""
        self._scorer = Scorer(self._reward)
        self._begin = self._best = float(distance)
        self._scorer.pay({"start": np.ones(1, bool), **dict.fromkeys(DISTANCES, np.full(1, self._begin)), **more})

    def pay(self, after: Float, more: Mapping[str, Float] = {}) -> Paid:
        """What the next steps of the episode pay, (n,), by the distances after them, (n,), [m], and `more` of each.

        Raises:
            MissingField: The reward reads something else.
        """
        after = np.asarray(after, np.float64)
        best = np.minimum.accumulate(np.concatenate([[self._best], after]))
        self._best = float(best[-1])
        distances = (np.full(len(after), self._begin), best[:-1], after)
        start = np.zeros(len(after), bool)
        return self._scorer.pay({"start": start, **dict(zip(DISTANCES, distances, strict=True)), **more})


def _sized(numbers: Float, name: str, count: int) -> Float:
    if numbers.shape[1] != count:
        raise UsageError(
            f"{name} has {numbers.shape[1]} numbers: a position has 3 and a distance 1, in metres, as in {EXAMPLE} or "
            "distance=17:18"
        )
    return numbers

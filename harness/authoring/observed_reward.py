"""Rewards of an arm in an environment of anybody, where the observation tells where end effector and target are."""

import re
from dataclasses import dataclass
from typing import Any, Self

import numpy as np

from harness.arrays import Float
from harness.env.shaping import Shaping
from harness.errors import UsageError
from harness.reward import Reward, Sample

_PLACE = re.compile(r"(\w+)=(\d+)(?::(\d+))?")
ALL = np.ones(1, bool)
SYNTAX = "write end_effector=0:3,target=3:6, or distance=17"


@dataclass(frozen=True)
class ObservedPlaces:
    """Which numbers of an observation say where things are. The first number has place 0; ends are exclusive.

    Attributes:
        end_effector: Its position, three numbers, [m].
        target: The target's position in the same frame, three numbers, [m].
        distance: The distance between the two, one number, [m]; not needed where both positions are observed.
        renewed: Numbers that change when a new target is drawn inside an episode, and only then. Distances begin anew
            there. None: a target that moves stays the same target.
    """

    end_effector: slice | None = None
    target: slice | None = None
    distance: slice | None = None
    renewed: slice | None = None

    @classmethod
    def parse(cls, text: str) -> Self:
        """Read ``end_effector=0:3,target=3:6``; ``distance=17`` is short for ``distance=17:18``.

        Raises:
            UsageError: The text is malformed, or does not tell a distance.
        """
        found: dict[str, slice] = {}
        for part in filter(None, (it.strip() for it in text.split(","))):
            place = _PLACE.fullmatch(part)
            if place is None or place[1] not in cls.__dataclass_fields__:
                known = ", ".join(cls.__dataclass_fields__)
                raise UsageError(f"places: '{part}' is malformed or names none of {known}: {SYNTAX}")
            begin = int(place[2])
            found[place[1]] = slice(begin, int(place[3]) if place[3] else begin + 1)
        places = cls(**found)
        places._require_lengths()
        return places

    def require_within(self, size: int) -> None:
        """See that observations have all of these places.

        Args:
            size: How many numbers an observation has.

        Raises:
            UsageError: They are shorter.
        """
        for name, place in self._given().items():
            if place.stop > size:
                raise UsageError(f"places: {name}={place.start}:{place.stop}, and an observation has {size} numbers")

    def distance_in(self, observation: Any, target_of: Any = None) -> float:
        """The distance from end effector to target, [m].

        Args:
            observation: Where the end effector is.
            target_of: Another observation that tells the target, if it is not the same. Without positions it is not
                known how close the end effector came to that target; 0 is taken.
        """
        if self.end_effector is None or self.target is None:
            assert self.distance is not None
            return 0.0 if target_of is not None else float(observation[self.distance][0])
        target = (observation if target_of is None else target_of)[self.target]
        return float(np.linalg.norm(np.subtract(observation[self.end_effector], target, dtype=np.float64)))

    def has_new_target(self, before: Any, after: Any) -> bool:
        """Whether another target was drawn between two observations."""
        return self.renewed is not None and not np.array_equal(before[self.renewed], after[self.renewed])

    def _given(self) -> dict[str, slice]:
        return {name: place for name, place in vars(self).items() if place is not None}

    def _require_lengths(self) -> None:
        if self.distance is None and (self.end_effector is None or self.target is None):
            raise UsageError(f"places: neither both positions nor a distance are given: {SYNTAX}")
        for name, place in self._given().items():
            wanted = {"distance": 1, "renewed": max(1, place.stop - place.start)}.get(name, 3)
            if place.stop - place.start != wanted:
                raise UsageError(f"places: {name}={place.start}:{place.stop} has to be {wanted} numbers: {SYNTAX}")


class ObservedReward:
    """An arm's reward as a function of observations, for `harness.environment.Environment.rewards`.

    It pays what the reward pays in the tasks of this project: the distances of the episode are followed in the same
    way. What a task pays besides, such as a penalty for the ground, no observation tells.
    """

    def __init__(self, reward: Reward, places: ObservedPlaces, steps: int = 1) -> None:
        """Pay nothing yet.

        Args:
            reward: A registered reward, built.
            places: Where an observation tells the distance.
            steps: Environment steps between two observations, each of which pays. The arm is taken to be where it is
                observed next in all of them, and to stop at a terminal step: a step that terminates an episode pays
                once.
        """
        self._shaping, self._places, self._steps = Shaping(reward), places, steps
        self._begin = self._best = self._last = 0.0
        self._step, self._is_begun = 0, False

    def reset(self) -> None:
        """An episode starts."""
        self._is_begun = False

    def __call__(self, observation: Any, action: Any, next_observation: Any, info: Any) -> float:
        """What the step pays, in the reward's unit."""
        if not self._is_begun:
            self._begin_at(self._places.distance_in(observation))
            self._step, self._is_begun = 0, True
        steps = 1 if info.get("terminated") else self._steps
        if not self._places.has_new_target(observation, next_observation):
            distance = self._places.distance_in(next_observation)
            return sum(self._pay(distance) for _ in range(steps))
        paid = self._pay(self._places.distance_in(next_observation, target_of=observation))
        distance = self._places.distance_in(next_observation)
        self._begin_at(distance)
        return paid + sum(self._pay(distance) for _ in range(steps - 1))

    def _begin_at(self, distance: float) -> None:
        self._begin = self._best = self._last = distance
        self._shaping.restart(ALL, np.array([distance]))

    def _pay(self, distance: float) -> float:
        self._step += 1
        numbers = (self._begin, self._best, self._last, distance, distance - self._best, float(self._step))
        paid = self._shaping.pay(Sample(*(_alone(number) for number in numbers)))
        self._best, self._last = min(self._best, distance), distance
        return float(paid[0])


def _alone(number: float) -> Float:
    return np.array([number])

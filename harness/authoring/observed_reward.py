"""Rewards of an arm in an environment of anybody, where the observation tells where end effector and target are."""

from typing import Any

import numpy as np

from harness.reward import Reward
from harness.score.places import ArmPay, ArmPlaces, parse_places


class ObservedReward:
    """An arm's reward as a function of observations, for `harness.environment.Environment.rewards`.

    It pays what the reward pays in the tasks of this project: the distances of the episode are followed in the same
    way. What a task pays besides, such as a penalty for the ground, no observation tells.
    """

    def __init__(self, reward: Reward, places: ArmPlaces | str, steps: int = 1) -> None:
        """Pay nothing yet.

        Args:
            reward: A registered reward, built.
            places: Where an observation tells the distance, such as ``end_effector=0:3,target=3:6``.
            steps: Environment steps between two observations, each of which pays. The arm is taken to be where it is
                observed next in all of them, and to stop at a terminal step: a step that terminates an episode pays
                once. Whether it does is what ``info["terminated"]`` says.
        """
        self._pay, self._steps, self._is_begun = ArmPay(reward), steps, False
        self._places = parse_places(places) if isinstance(places, str) else places

    def reset(self) -> None:
        """An episode starts."""
        self._is_begun = False

    def __call__(self, observation: Any, action: Any, next_observation: Any, info: Any) -> float:
        """What the step pays, in the reward's unit."""
        before, after = np.asarray(observation)[None], np.asarray(next_observation)[None]
        if not self._is_begun:
            self._pay.begin(self._places.distances(before)[0])
            self._is_begun = True
        steps = 1 if info.get("terminated") else self._steps
        distance = self._places.distances(after)[0]
        if not self._places.has_new_target(before, after)[0]:
            return float(self._pay.pay(np.full(steps, distance)).total.sum())
        paid = float(self._pay.pay(self._places.reached(before, after)).total.sum())
        self._pay.begin(distance)
        return paid + float(self._pay.pay(np.full(steps - 1, distance)).total.sum()) if steps > 1 else paid

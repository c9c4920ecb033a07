"""Gymnasium's inverted double pendulum, with the rewards of its fourth and its fifth version."""

import math
from collections.abc import Mapping
from typing import Any, ClassVar

import gymnasium
from pydantic.dataclasses import dataclass

from harness.environment import AnyEnv
from harness.reward import Given

ALIVE = 10.0
"""Paid for each step. From version 5 on it is not paid for the step in which the pendulum falls."""
FALLEN, UPRIGHT = 1.0, 2.0
"""Heights of the tip, [m]. At `FALLEN` or below, the pendulum has fallen. At `UPRIGHT` the penalty is least."""


@dataclass(frozen=True)
class InvertedDoublePendulum:
    """A cart balances two poles, one on the other (MuJoCo); an episode ends when they fall, or after 1,000 steps.

    Versions 4 and 5 of Gymnasium's environment move alike and pay differently. For being upright, v4 pays 10 in the
    step of the fall too, v5 does not. Both rewards pay for the same steps, which are those of version 5.
    """

    higher_is_better: ClassVar[frozenset[str]] = frozenset({"steps_balanced"})
    lower_is_better: ClassVar[frozenset[str]] = frozenset({"tip_distance"})
    bounds: ClassVar[Mapping[str, tuple[float, float]]] = {
        "steps_balanced": (1.0, 1000.0),
        "tip_distance": (0.0, math.inf),
    }
    baseline: ClassVar[str] = "v4"

    def make(self) -> AnyEnv:
        return gymnasium.make("InvertedDoublePendulum-v5")

    def rewards(self, env: AnyEnv) -> Mapping[str, Given]:
        physics = env.unwrapped

        def v4(observation: Any, action: Any, next_observation: Any, info: Any) -> float:
            return ALIVE - _penalties(physics)

        def v5(observation: Any, action: Any, next_observation: Any, info: Any) -> float:
            return ALIVE * (_height(physics) > FALLEN) - _penalties(physics)

        return {"v4": v4, "v5": v5}

    def behaviour(self, env: AnyEnv) -> Mapping[str, Given]:
        physics = env.unwrapped

        def tip_distance(observation: Any, action: Any, next_observation: Any, info: Any) -> float:
            """Distance from the tip to its place when it is upright over the middle, [m]."""
            x, _, y = physics.data.site_xpos[0]  # type: ignore[attr-defined] # it is MuJoCo's
            return float((x**2 + (y - UPRIGHT) ** 2) ** 0.5)

        return {"steps_balanced": StepsBalanced(), "tip_distance": tip_distance}


class StepsBalanced:
    """How many steps of the episode are done; the episode ends when the pendulum falls."""

    def __init__(self) -> None:
        self.steps = 0

    def reset(self) -> None:
        """An episode starts."""
        self.steps = 0

    def __call__(self, observation: Any, action: Any, next_observation: Any, info: Any) -> int:
        """Count one more step; returns the steps so far."""
        self.steps += 1
        return self.steps


def _height(physics: Any) -> float:
    """Height of the tip, [m]."""
    return float(physics.data.site_xpos[0][2])


def _penalties(physics: Any) -> float:
    """The penalty for the distance of the tip and the speeds of the joints. Both versions have the same."""
    x, _, y = physics.data.site_xpos[0]
    v1, v2 = physics.data.qvel[1:3]
    return float(0.01 * x**2 + (y - UPRIGHT) ** 2 + 1e-3 * v1**2 + 5e-3 * v2**2)

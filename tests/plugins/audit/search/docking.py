"""A ship that draws itself, and one whose waves no seed tells."""

from dataclasses import dataclass

import gymnasium
import numpy as np
from numpy.random import default_rng

from tests.plugins.audit.cases.docking import Docking as Calm, _Dock


class Ship(_Dock):
    """Waves push it, and it is seen from above."""

    metadata = {"render_modes": ["rgb_array"]}  # noqa: RUF012
    render_mode = None

    def __init__(self, waves):
        self.waves = waves

    def step(self, action):
        self.position = self.position + self.waves * default_rng().normal(size=2)
        return super().step(action)

    def render(self):
        picture = np.full((20, 30, 3), 255, np.uint8)
        x, y = np.clip(10 + 5 * self.position, 0, 19).astype(int)
        picture[y, x] = 0
        return picture


@dataclass(frozen=True)
class Docking(Calm):
    """The environment.

    Attributes:
        waves: How far unseeded waves push, each step.
    """

    waves: float = 0.0

    def make(self):
        """An env of 12 steps."""
        return gymnasium.wrappers.TimeLimit(Ship(self.waves), 12)

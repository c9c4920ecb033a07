"""Frames for simulators that draw none of their own."""

import numpy as np
from numpy.typing import NDArray

from harness.arrays import Float
from harness.record.scene import Scene
from harness.robot import Robot
from harness.scene.picture import draw_still
from harness.scene.scene import scene_of


class StillFrames:
    """Pictures of a robot without any engine."""

    def __init__(self, robot: Robot) -> None:
        """Nothing is looked at before the first picture."""
        self._robot = robot
        self._scene: Scene | None = None

    def frame(self, qpos: Float, target: Float, width: int, height: int) -> NDArray[np.uint8]:
        """The arm at `qpos`, (dof,), and a marker at `target`, (3,), [m]; RGB, (height, width, 3).

        Raises:
            UsageError: pillow is missing.
        """
        if self._scene is None:
            self._scene = scene_of(self._robot)
        return np.array(draw_still(self._scene, qpos, target, width, height))

    def close(self) -> None:
        """Does nothing: there is nothing to give back."""

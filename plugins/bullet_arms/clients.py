"""Bullet's clients of one simulation, which are closed together."""

import weakref

import numpy as np
import pybullet
from numpy.typing import NDArray

from harness.arrays import Float
from harness.errors import UsageError
from harness.robot import Robot

from .scene import Scene


class Clients:
    """Bullet's clients: one for the world of each arm, and one for frames, which is opened for the first frame.

    They are closed by `close`, or when the program no longer refers to this object.

    Attributes:
        numbers: Bullet's numbers of the clients, in the order in which they were opened.
    """

    def __init__(self, robot: Robot) -> None:
        self._robot = robot
        self.numbers: list[int] = []
        self._scene: Scene | None = None
        self._disconnect = weakref.finalize(self, _disconnect, self.numbers)

    def connect(self) -> int:
        """The number of a new client without a window.

        Raises:
            UsageError: This process has as many clients as it can have.
        """
        try:
            client = int(pybullet.connect(pybullet.DIRECT))
        except pybullet.error as error:
            raise UsageError(
                f"PyBullet opens no more clients ({error}): take fewer envs, or another simulator"
            ) from error
        self.numbers.append(client)
        return client

    def frame(self, qpos: Float, target: Float, width: int, height: int) -> NDArray[np.uint8]:
        """See `harness_plugins.arms.apart.Frames`."""
        if self._scene is None:
            self._scene = Scene(self.connect(), self._robot)
        return self._scene.frame(qpos, target, width, height)

    def close(self) -> None:
        """See `harness_plugins.arms.apart.Frames`."""
        self._disconnect()


def _disconnect(clients: list[int]) -> None:
    for client in clients:
        pybullet.disconnect(physicsClientId=client)

"""Bullet's clients of one simulation, which are closed together."""

import weakref

import numpy as np
import pybullet
from numpy.typing import NDArray

from harness.arrays import Float
from harness.errors import UsageError
from harness.robot import Robot

from .arm_file import file_of_arm
from .world import LOAD_FLAGS, load_body, numbers, set_joints


class Scene:
    """A world that is only drawn: ground, arm and target, by Bullet's own software renderer."""

    def __init__(self, client: int, robot: Robot) -> None:
        self.client = client
        with file_of_arm(robot, is_drawn=True) as path:
            self.body = load_body(client, robot, path, LOAD_FLAGS)
        _, self.joints = numbers(client, self.body, robot)
        _add_shape(client, [0.0, 0.0, -0.01], pybullet.GEOM_BOX, halfExtents=[3, 3, 0.01], rgbaColor=[0.8, 0.8, 0.8, 1])
        red = [0.85, 0.2, 0.15, 1]
        self.target = _add_shape(client, [0.0, 0.0, 0.0], pybullet.GEOM_SPHERE, radius=0.03, rgbaColor=red)

    def frame(self, qpos: Float, target: Float, width: int, height: int) -> NDArray[np.uint8]:
        """The arm at `qpos`, (dof,), and a marker at `target`, (3,), [m]; RGB, (height, width, 3)."""
        client = self.client
        set_joints(client, self.body, self.joints, qpos)
        pybullet.resetBasePositionAndOrientation(self.target, list(target), [0, 0, 0, 1], physicsClientId=client)
        view = pybullet.computeViewMatrixFromYawPitchRoll([0.4, 0.0, 0.6], 3.0, 40.0, -20.0, 0.0, 2)
        image = pybullet.getCameraImage(
            width, height, view, pybullet.computeProjectionMatrixFOV(45.0, width / height, 0.05, 20.0),
            renderer=pybullet.ER_TINY_RENDERER, physicsClientId=client,
        )  # fmt: skip
        pixels = np.array(image[2], np.uint8).reshape(height, width, 4)  # a copy, since the array is Bullet's
        return np.ascontiguousarray(pixels[..., :3])


def _add_shape(client: int, position: list[float], kind: int, **shape: object) -> int:
    """Add a shape at `position`, (3,), [m], that is drawn and touches nothing; Bullet's number of it."""
    visual = pybullet.createVisualShape(kind, physicsClientId=client, **shape)
    return int(
        pybullet.createMultiBody(0.0, baseVisualShapeIndex=visual, basePosition=position, physicsClientId=client)
    )


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
        if self._scene is None:
            self._scene = Scene(self.connect(), self._robot)
        return self._scene.frame(qpos, target, width, height)

    def close(self) -> None:
        self._disconnect()


def _disconnect(clients: list[int]) -> None:
    for client in clients:
        pybullet.disconnect(physicsClientId=client)

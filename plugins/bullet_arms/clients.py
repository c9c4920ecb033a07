"""Bullet's clients of one simulation, which are closed together."""

import weakref
from collections.abc import Sequence

import numpy as np
import pybullet
from numpy.typing import NDArray

from harness import Float
from harness.errors import UsageError
from harness.robot import Robot
from harness.simulator import Camera

from .arm_file import file_of_arm
from .world import LOAD_FLAGS, load_body, numbers, set_joints

DEPTHS = (0.02, 8.0)
"""The nearest and the farthest that is drawn, as shares of the camera's distance from what it looks at."""

GROUND = 3.0
"""Half the edge of the ground that is drawn, in radii of what is seen; never less than 3 m."""


class Scene:
    """A world that is only drawn: ground, arm and target, by Bullet's own software renderer."""

    def __init__(self, client: int, robot: Robot) -> None:
        self.client, self._robot = client, robot
        self._camera = camera = Camera.of(robot, 1, 1)
        edge = max(3.0, GROUND * camera.radius)
        with file_of_arm(robot, is_drawn=True) as path:
            self.body = load_body(client, robot, path, LOAD_FLAGS)
        _, self.joints = numbers(client, self.body, robot)
        _add_shape(
            client, [0.0, 0.0, -0.01], pybullet.GEOM_BOX, halfExtents=[edge, edge, 0.01], rgbaColor=[0.8, 0.8, 0.8, 1]
        )
        red = [0.85, 0.2, 0.15, 1]
        self.target = _add_shape(client, [0.0, 0.0, 0.0], pybullet.GEOM_SPHERE, radius=camera.marker, rgbaColor=red)

    def frame(self, qpos: Float, target: Float, width: int, height: int) -> NDArray[np.uint8]:
        """The arm at `qpos`, (dof,), and a marker at `target`, (3,), [m]; RGB, (height, width, 3)."""
        client = self.client
        set_joints(client, self.body, self.joints, qpos)
        pybullet.resetBasePositionAndOrientation(self.target, list(target), [0, 0, 0, 1], physicsClientId=client)
        if (width, height) != (self._camera.width, self._camera.height):
            self._camera = Camera.of(self._robot, width, height)
        image = pybullet.getCameraImage(
            width, height, *_matrices(self._camera),
            renderer=pybullet.ER_TINY_RENDERER, physicsClientId=client,
        )  # fmt: skip
        pixels = np.array(image[2], np.uint8).reshape(height, width, 4)  # a copy, since the array is Bullet's
        return np.ascontiguousarray(pixels[..., :3])


def _matrices(camera: Camera) -> tuple[Sequence[float], Sequence[float]]:
    """Bullet's view and projection; its yaw is 0 where a camera looks along y."""
    view = pybullet.computeViewMatrixFromYawPitchRoll(
        camera.centre.tolist(), camera.distance, camera.azimuth - 90.0, camera.elevation, 0.0, 2
    )
    near, far = (share * camera.distance for share in DEPTHS)
    ratio = camera.width / camera.height
    return view, pybullet.computeProjectionMatrixFOV(camera.field_of_view, ratio, near, far)


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

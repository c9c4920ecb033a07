"""The coordinate systems that a linear or an arc movement is given in (note 105c)."""

from dataclasses import dataclass
from typing import Annotated, Literal

import numpy as np
from pydantic import Field
from pydantic.dataclasses import dataclass as checked_dataclass

from harness.arrays import Float
from harness.errors import UsageError
from harness.robot import Robot
from harness.robot.kinematics import forward

Metres3 = tuple[float, float, float]
Positive = Annotated[float, Field(gt=0)]


@checked_dataclass(frozen=True)
class CartesianMode:
    """What `movel` and `movea` have in common."""

    frame: Annotated[
        Literal["wcs", "ucs", "tcs"],
        Field(description="axes of the action: the world's (wcs), the user's (ucs), or the tool's at each step (tcs)"),
    ] = "wcs"
    tip_speed: Annotated[Positive, Field(description="speed of the end effector under a full action [m/s]")] = 0.5
    parts: Annotated[int, Field(gt=0, description="pieces into which the path of a control period is cut")] = 4
    ucs_origin: Annotated[Metres3, Field(description="origin of the user's frame, world frame [m]")] = (
        0.0,
        0.0,
        0.0,
    )
    ucs_x: Annotated[Metres3, Field(description="a point on the user's +x axis, world frame [m]")] = (
        1.0,
        0.0,
        0.0,
    )
    ucs_xy: Annotated[
        Metres3, Field(description="a point in the first quadrant of the user's xy plane, world frame [m]")
    ] = (
        0.0,
        1.0,
        0.0,
    )

    def axes(self, robot: Robot) -> "Axes":
        """The axes of `frame`.

        Raises:
            UsageError: The user's three points lie on one line.
        """
        if self.frame == "tcs":
            return ToolAxes(robot)
        return FixedAxes(np.eye(3) if self.frame == "wcs" else self._user_axes())

    def _user_axes(self) -> Float:
        """The user's axes as columns, (3, 3)."""
        origin = np.array(self.ucs_origin)
        x, towards_y = np.array(self.ucs_x) - origin, np.array(self.ucs_xy) - origin
        z = np.cross(x, towards_y)
        if np.linalg.norm(z) < 1e-9:
            raise UsageError(
                f"ucs_origin={self.ucs_origin}, ucs_x={self.ucs_x} and ucs_xy={self.ucs_xy} lie on one line: "
                "give three points that span a plane"
            )
        return np.stack([x / np.linalg.norm(x), _unit(np.cross(z, x)), _unit(z)], axis=1)


@dataclass(frozen=True, eq=False)
class FixedAxes:
    """Axes that stand still, (3, 3), a column each."""

    columns: Float

    def to_world(self, qpos: Float, vectors: Float) -> Float:
        """Vectors, (num_envs, count, 3), turned into the world frame."""
        turned: Float = vectors @ self.columns.T
        return turned


@dataclass(frozen=True, eq=False)
class ToolAxes:
    """The end effector link's axes at joint positions `qpos`."""

    robot: Robot

    def to_world(self, qpos: Float, vectors: Float) -> Float:
        """Vectors, (num_envs, count, 3), turned into the world frame."""
        turned: Float = vectors @ np.swapaxes(forward(self.robot.chain, qpos)[:, :3, :3], -1, -2)
        return turned


Axes = FixedAxes | ToolAxes


def _unit(vector: Float) -> Float:
    unit: Float = vector / np.linalg.norm(vector)
    return unit

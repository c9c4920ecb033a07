"""What an arm looks like, and how its joints move it: `scene.json` in a cell's folder.

With it, recorded joint positions become pictures without the robot's files and without any simulator.
"""

import base64
import json
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, StringConstraints, with_config
from typing_extensions import TypedDict

from harness.arrays import Float
from harness.files.bounded import read_json, reading, write_whole
from harness.record.file_forms import EXACT, Name, read_form, told_as
from harness.record.folder import SCENE

FORMAT: Literal[1] = 1
MOST_BYTES = 4 * 2**20
"""The most bytes of a file; one that we write has a tenth of it."""
MOST_JOINTS, MOST_BODIES, MOST_TRIANGLES = 16, 1_000, 50_000
ROUNDING = 1e-6
"""The rounding of rotations and unit vectors."""
FULL = 32_767
"""Points are whole numbers up to it, in parts of the largest coordinate of their body."""

Number = Annotated[float, Field(allow_inf_nan=False, ge=-1e6, le=1e6)]
Bytes = Annotated[str, StringConstraints(max_length=MOST_BYTES)]
Colour = Annotated[str, StringConstraints(pattern="^#[0-9a-f]{6}$")]


def _frame(numbers: list[float]) -> Float:
    frame = np.reshape(numbers, (3, 4))
    if not (np.abs(frame[:, :3] @ frame[:, :3].T - np.eye(3)) < ROUNDING).all():
        raise ValueError("it is no rotation with a translation")
    return frame


def _axis(numbers: list[float]) -> Float:
    if abs(np.linalg.norm(numbers) - 1.0) >= ROUNDING:
        raise ValueError("it is no unit vector")
    return np.array(numbers)


Frame = Annotated[Float, told_as(Annotated[list[Number], Field(min_length=12, max_length=12)], _frame)]
Axis = Annotated[Float, told_as(Annotated[list[Number], Field(min_length=3, max_length=3)], _axis)]


@with_config(EXACT)
@dataclass(frozen=True, eq=False)
class SceneJoint:
    """One joint that moves.

    Attributes:
        frame: Its frame in the child frame of the joint before it, the first one's in the world; without the last row,
            shape (3, 4), translation in [m].
        axis: Unit vector of its motion in its frame, shape (3,).
        slides: Whether it slides along the axis, and does not turn about it.
    """

    frame: Frame
    axis: Axis
    slides: bool


@dataclass(frozen=True, eq=False)
class Body:
    """Triangles of one colour that move together.

    Attributes:
        joint: Number of the joint that moves them; -1 where none does.
        colour: As ``#rrggbb``.
        points: Corners in the joint's child frame, or in the world, shape (count, 3), [m].
        faces: Numbers of each triangle's corners, counter-clockwise from outside, shape (triangles, 3).
    """

    joint: int
    colour: str
    points: Float
    faces: NDArray[np.uint16]

    def to_json(self) -> dict[str, Any]:
        """See `Scene.to_json`."""
        scale = max(float(np.abs(self.points).max(initial=0.0)), 1e-9) / FULL
        points, faces = np.rint(self.points / scale).astype("<i2"), self.faces.astype("<u2")
        packed = {name: base64.b64encode(it.tobytes()).decode() for name, it in (("points", points), ("faces", faces))}
        return {"joint": self.joint, "colour": self.colour, "scale": scale, **packed}


@with_config(EXACT)
class BodyForm(TypedDict):
    """See `Body`."""

    joint: Annotated[int, Field(ge=-1)]
    colour: Colour
    scale: Annotated[float, Field(gt=0, le=1e3)]
    points: Bytes
    faces: Bytes


def _body(told: BodyForm) -> Body:
    points, faces = (
        np.frombuffer(base64.b64decode(packed, validate=True), kind).reshape(-1, 3)
        for packed, kind in ((told["points"], "<i2"), (told["faces"], "<u2"))
    )
    if faces.size and faces.max() >= len(points):
        raise ValueError("it has triangles with corners that it does not have")
    return Body(told["joint"], told["colour"], points * told["scale"], faces.astype(np.uint16))


@with_config(EXACT)
@dataclass(frozen=True, eq=False)
class Scene:
    """An arm as it is drawn.

    Attributes:
        robot: Its name.
        joints: In order from the root, dof of them; positions of recorded rows have their order.
        tip: The end effector's frame in the last joint's child frame, shape (3, 4), [m].
        bodies: All that is drawn.
    """

    robot: Name
    joints: Annotated[tuple[SceneJoint, ...], Field(min_length=1, max_length=MOST_JOINTS)]
    tip: Frame
    bodies: Annotated[tuple[Annotated[Body, told_as(BodyForm, _body)], ...], Field(max_length=MOST_BODIES)]
    format: Literal[1] = FORMAT

    def to_json(self) -> dict[str, Any]:
        """Plain data; points are rounded to 1/32767 of the largest coordinate of their body."""
        return {
            "format": FORMAT,
            "robot": self.robot,
            "joints": [
                {"frame": joint.frame.ravel().tolist(), "axis": joint.axis.tolist(), "slides": joint.slides}
                for joint in self.joints
            ],
            "tip": self.tip.ravel().tolist(),
            "bodies": [body.to_json() for body in self.bodies],
        }


def write_scene(scene: Scene, folder: Path) -> None:
    """Leave `scene` in a cell's folder."""
    write_whole(folder / SCENE, json.dumps(scene.to_json(), separators=(",", ":"), allow_nan=False))


def read_scene(folder: Path) -> Scene | None:
    """The scene in a cell's folder; None where the cell left none, as those of version 0.1.

    Raises:
        SchemaError: The file is damaged or written by a newer version.
    """
    path = folder / SCENE
    if not path.is_file():
        return None
    with reading(path, "scene"):
        return scene_from_json(read_json(path, MOST_BYTES))


def scene_from_json(data: Any) -> Scene:
    """The scene that `Scene.to_json` wrote.

    Raises:
        ValueError: It is something else.
    """
    scene = read_form(Scene, data)
    for body in scene.bodies:
        if body.joint >= len(scene.joints):
            raise ValueError(f"it has a body of joint {body.joint}, and {len(scene.joints)} joints")
    if sum(len(body.faces) for body in scene.bodies) > MOST_TRIANGLES:
        raise ValueError(f"it has more than {MOST_TRIANGLES:,} triangles")
    return scene

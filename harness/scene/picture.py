"""Pictures of an arm without any engine: shaded triangles, drawn from the farthest to the nearest by pillow."""

import math
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from harness.arrays import Float
from harness.record.scene import Scene
from harness.registry.spec import require_pillow
from harness.robot import Robot
from harness.robot.kinematics import Chain, child_frames, link_frames
from harness.scene.scene import scene_of

if TYPE_CHECKING:
    from PIL import Image, ImageDraw

LIGHT = np.array([-0.35, -0.5, 0.8])
"""Where it comes from."""
BACKGROUND, GRID, SHADOW, TARGET = "#f3f5f7", "#dcdfe3", "#cfd3d8", "#00805c"
MARKER = 0.03
"""The radius of the ball at a target, as a share of that of what is seen."""
FINER = 2
"""Pixels are drawn smaller by this, and averaged: edges are smooth."""
MARGIN, FITTINGS = 1.15, 8
"""Around what is seen, and how often it is fitted into the picture: nearer, it looks larger than in proportion."""
FOCAL, AWAY, TURN, RISE = 2.6, 2.8, -0.9, 0.35
"""The camera: focal length, distance in radii of what it shows, and where it stands, [rad]."""
POSES, AROUND, FARTHEST = 64, 0.25, math.pi / 4.0
"""The number of poses that are seen, each joint within this share of its range from home, and no farther, [rad]."""
DIRECTIONS = 512
"""The number of directions in which the farthest of all points are kept."""


@dataclass(frozen=True, eq=False)
class Camera:
    """Looks at a ball around `centre`, from the side and a little from above.

    Attributes:
        centre: World frame, [m], (3,).
        radius: [m].
        width: Of the picture, in pixels.
        height: Likewise.
    """

    centre: Float
    radius: float
    width: int
    height: int

    @classmethod
    def of(cls, robot: Robot, width: int, height: int) -> "Camera":
        """The camera that shows an arm as every simulator does, in a picture of `width` times `height` pixels."""
        return camera_for(seen_of(robot), width, height)

    @cached_property
    def axes(self) -> Float:
        """Right, up and towards the camera in the world frame, (3, 3)."""
        c, s, up, level = np.cos(TURN), np.sin(TURN), np.sin(RISE), np.cos(RISE)
        return np.array([[-s, c, 0.0], [-up * c, -up * s, level], [level * c, level * s, up]])

    @property
    def eye(self) -> Float:
        """Where it stands, world frame, [m], (3,)."""
        eye: Float = self.centre + self.distance * self.axes[2]
        return eye

    @property
    def distance(self) -> float:
        """From the centre, [m]."""
        return AWAY * self.radius

    @property
    def marker(self) -> float:
        """The radius of a ball that marks the target, [m]."""
        return MARKER * self.radius

    @property
    def azimuth(self) -> float:
        """The direction in which it looks, about z from x, [deg]; it looks `elevation` upwards."""
        return math.degrees(TURN) + 180.0

    @property
    def elevation(self) -> float:
        """How far upwards it looks, [deg]; negative, since it looks down."""
        return -math.degrees(RISE)

    @property
    def field_of_view(self) -> float:
        """From the lower edge of the picture to the upper one, [deg]."""
        return 2.0 * math.degrees(math.atan(self.height / (FOCAL * min(self.width, self.height))))

    def project(self, points: Float) -> Float:
        """Column, row and depth of points, (..., 3), [m], in pixels and [m]: the same shape."""
        right, up, back = np.moveaxis((points - self.eye) @ self.axes.T, -1, 0)
        depth = np.maximum(-back, 1e-3 * self.radius)
        scale = FOCAL * min(self.width, self.height) / 2 / depth
        return np.stack([self.width / 2 + right * scale, self.height / 2 - up * scale, depth], axis=-1)


def camera_for(points: Float, width: int, height: int) -> Camera:
    """A camera that sees points, (count, 3), [m], in a picture of so many pixels.

    It also sees the world's origin, unless that is farther away than the points from one another: a small arm on a high
    table would be lost.
    """
    low, high = points.min(axis=0), points.max(axis=0)
    near = np.linalg.norm(np.clip(0.0, low, high)) <= np.linalg.norm(high - low)
    seen = np.vstack([points, np.zeros((int(near), 3))])
    low, high = seen.min(axis=0), seen.max(axis=0)
    camera = Camera((low + high) / 2, max(float(np.linalg.norm(high - low)) / 2, 1e-3), width, height)
    half = np.array([width, height]) / 2
    for _ in range(FITTINGS):  # a ball around it has room to spare
        flat = camera.project(seen)
        low, high = flat[:, :2].min(axis=0), flat[:, :2].max(axis=0)
        right, down = ((low + high) / 2 - half) * camera.distance / (FOCAL * half.min())
        filled = float(((high - low) / 2 / half).max())
        centre = camera.centre + right * camera.axes[0] - down * camera.axes[1]
        camera = replace(camera, centre=centre, radius=max(camera.radius * filled * MARGIN, 1e-3))
    return camera


def seen_of(robot: Robot, scene: Scene | None = None) -> Float:
    """What the pictures of a robot show in every simulator: the arm at home, and where it moves around there.

    Args:
        robot: The arm.
        scene: What is drawn of it; `scene_of` the robot if None.

    Returns:
        Points for `camera_for`, the outermost ones, world frame, [m], (count, 3).
    """
    drawn = np.random.default_rng(0).uniform(robot.lower, robot.upper, (POSES, robot.dof))
    farthest = FARTHEST * robot.per_radian
    poses = robot.home + np.clip(AROUND * (drawn - robot.home), -farthest, farthest)
    joints = np.moveaxis(link_frames(robot.chain, poses)[..., 3, :], 1, -1).reshape(-1, 3)
    solid = corners_of(scene or scene_of(robot), robot.home)[0].reshape(-1, 3)
    points = np.concatenate([solid, joints, robot.end_effector(poses)])
    directions = np.random.default_rng(0).standard_normal((3, DIRECTIONS))
    return np.asarray(points[np.unique((points @ directions).argmax(axis=0))])


def chain_of(scene: Scene) -> Chain:
    """The joints of a scene, ready to be computed with."""
    last = np.tile([0.0, 0.0, 0.0, 1.0], (len(scene.joints), 1, 1))
    frames = np.concatenate([np.stack([joint.frame for joint in scene.joints]), last], axis=1)
    kinds = tuple("prismatic" if joint.slides else "continuous" for joint in scene.joints)
    axes = np.stack([joint.axis for joint in scene.joints])
    return Chain(frames, axes, kinds, np.vstack([scene.tip, [0.0, 0.0, 0.0, 1.0]]))  # type: ignore[arg-type]


def corners_of(scene: Scene, qpos: Float) -> tuple[Float, Float]:
    """Every triangle of an arm at joint positions `qpos`, (dof,).

    Returns:
        Their corners in the world frame, [m], (triangles, 3, 3), and their colours, 0 to 255, (triangles, 3).
    """
    frames = [np.eye(4), *child_frames(chain_of(scene), qpos)]
    corners, colours = [np.empty((0, 3, 3))], [np.empty((0, 3))]
    for body in scene.bodies:
        frame = frames[body.joint + 1]
        corners.append((body.points @ frame[:3, :3].T + frame[:3, 3])[body.faces.astype(np.intp)])
        colours.append(np.tile([float(int(body.colour[at : at + 2], 16)) for at in (1, 3, 5)], (len(body.faces), 1)))
    return np.concatenate(corners), np.concatenate(colours)


def draw_arm(scene: Scene, qpos: Float, target: Float, path: Float, colour: str, camera: Camera) -> "Image.Image":
    """A picture of an arm.

    Args:
        scene: The arm.
        qpos: Joint positions, [rad] or [m], (dof,).
        target: Ringed, world frame, [m], (3,).
        path: The way of the end effector so far, world frame, [m], (points, 3).
        colour: Of the way.
        camera: Looks at it.

    Raises:
        UsageError: pillow is missing.
    """
    require_pillow()
    from PIL import Image, ImageDraw

    large = Camera(camera.centre, camera.radius, FINER * camera.width, FINER * camera.height)
    image = Image.new("RGB", (large.width, large.height), BACKGROUND)
    pen = ImageDraw.Draw(image)
    _draw_grid(pen, large)
    corners, colours = corners_of(scene, qpos)
    _draw_shadow(pen, large, corners)
    _draw_triangles(pen, large, corners, colours)
    flat = [tuple(point) for point in large.project(path)[:, :2].tolist()]
    if len(flat) > 1:
        pen.line(flat, "#ffffff", 5 * FINER, "curve")
        pen.line(flat, colour, 3 * FINER, "curve")
    (x, y), size = large.project(target)[:2].tolist(), 6 * FINER
    pen.ellipse((x - size, y - size, x + size, y + size), outline=TARGET, width=2 * FINER)
    return image.reduce(FINER)


def draw_still(
    scene: Scene, qpos: Float, target: Float, width: int, height: int, camera: Camera | None = None
) -> "Image.Image":
    """A picture of an arm that stands still, so many pixels wide and high; see `draw_arm`.

    Without a camera it sees the room above and before the world's origin that the links' lengths reach.

    Raises:
        UsageError: pillow is missing.
    """
    if camera is not None:
        return draw_arm(scene, qpos, target, np.empty((0, 3)), TARGET, camera)
    reach = np.sum([np.linalg.norm(joint.frame[:, 3]) for joint in scene.joints]) + np.linalg.norm(scene.tip[:, 3])
    whole = np.array([[-0.3, -0.3, 0.0], [0.5, 0.3, 0.8]]) * reach
    camera = camera_for(whole, width, height)
    return draw_arm(scene, qpos, target, np.empty((0, 3)), TARGET, camera)


def _draw_grid(pen: "ImageDraw.ImageDraw", camera: Camera) -> None:
    edge = 10.0 ** np.round(np.log10(camera.radius / 4))
    size = np.ceil(1.3 * camera.radius / edge) * edge
    x, y = np.round(camera.centre[:2] / edge) * edge
    for at in np.arange(-size, size + edge / 2, edge):
        for ends in (((x + at, y - size), (x + at, y + size)), ((x - size, y + at), (x + size, y + at))):
            line = camera.project(np.array([[*end, 0.0] for end in ends]))[:, :2]
            pen.line(line.ravel().tolist(), GRID, FINER)


def _draw_shadow(pen: "ImageDraw.ImageDraw", camera: Camera, corners: Float) -> None:
    """On the ground, of what the light reaches: the rest lies within it."""
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    lit = corners[normals @ LIGHT > 0]
    fallen = lit - lit[..., 2:] / LIGHT[2] * LIGHT
    for triangle in camera.project(fallen)[..., :2].reshape(-1, 6).tolist():
        pen.polygon(triangle, SHADOW)


def _draw_triangles(pen: "ImageDraw.ImageDraw", camera: Camera, corners: Float, colours: Float) -> None:
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    seen = ((camera.eye - corners[:, 0]) * normals).sum(axis=1) > 0
    corners, normals, colours = corners[seen], normals[seen], colours[seen]
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-12)
    bright = 0.42 + 0.5 * np.maximum(normals @ (LIGHT / np.linalg.norm(LIGHT)), 0.0) + 0.13 * normals[:, 2]
    shaded = np.clip(colours * bright[:, None], 0, 255).astype(int)
    flat = camera.project(corners)
    order = np.argsort(-flat[..., 2].mean(axis=1))
    for triangle, colour in zip(flat[order, :, :2].reshape(-1, 6).tolist(), shaded[order].tolist(), strict=True):
        pen.polygon(triangle, tuple(colour))


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
            self._seen = seen_of(self._robot, self._scene)
        camera = camera_for(self._seen, width, height)
        return np.array(draw_still(self._scene, qpos, target, width, height, camera))

    def close(self) -> None:
        """Does nothing: there is nothing to give back."""

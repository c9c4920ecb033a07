"""An arm as a line through its joints, as SVG: what is seen of an episode's end where no script draws it."""

import math
from collections.abc import Sequence

import numpy as np

from harness.arrays import Float
from harness.record.scene import Scene, SceneJoint
from harness.results.replay import Side

TURN, RISE = -0.9, 0.35
"""Where the camera stands, as in the replay, [rad]."""
AIR = 0.15
"""Around what is seen, as a share of its size."""


def draw_sticks(sides: Sequence[Side], index: int) -> tuple[str, ...]:
    """The end of an episode of each side, with the target as a ring; all in one scale.

    Args:
        sides: The sides of a show.
        index: The place of the episode in it.
    """
    ends = [side.episodes[index] for side in sides]
    arms = [_seen(joints_of(side.scene, it.qpos[-1])) for side, it in zip(sides, ends, strict=True)]
    targets = [_seen(it.target[-1:])[0] for it in ends]
    points = np.vstack([*arms, *targets])
    middle, size = (points.min(axis=0) + points.max(axis=0)) / 2, float(np.ptp(points, axis=0).max()) * (1 + AIR)
    left, top = middle - size / 2
    box = f'viewBox="{left:.3f} {top:.3f} {size:.3f} {size:.3f}" aria-hidden="true"'
    return tuple(
        f'<svg class="stick" {box}><polyline points="{" ".join(f"{x:.3f},{y:.3f}" for x, y in arm)}" fill="none" '
        f'stroke="currentColor" stroke-width="{size / 30:.4f}" stroke-linejoin="round"/><circle cx="{target[0]:.3f}" '
        f'cy="{target[1]:.3f}" r="{size / 25:.4f}" fill="none" stroke="#00805c" stroke-width="{size / 60:.4f}"/></svg>'
        for arm, target in zip(arms, targets, strict=True)
    )


def joints_of(scene: Scene, qpos: Float) -> Float:
    """The foot, each joint and the end effector at joint positions, (dof,), in the world frame, [m], (dof + 2, 3)."""
    frame, points = np.eye(4), [np.zeros(3)]
    for joint, position in zip(scene.joints, qpos, strict=True):
        frame = frame @ _whole(joint.frame) @ _motion(joint, float(position))
        points.append(frame[:3, 3])
    return np.array([*points, (frame @ _whole(scene.tip))[:3, 3]])


def _motion(joint: SceneJoint, position: float) -> Float:
    motion, (x, y, z) = np.eye(4), joint.axis
    if joint.slides:
        motion[:3, 3] = joint.axis * position
    else:  # Rodrigues' formula
        across = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
        motion[:3, :3] += math.sin(position) * across + (1.0 - math.cos(position)) * across @ across
    return motion


def _whole(frame: Float) -> Float:
    """A frame of three rows, (3, 4), as one of four."""
    return np.vstack([frame, [0.0, 0.0, 0.0, 1.0]])


def _seen(points: Float) -> Float:
    """To the right and downwards in the picture, (count, 2), [m]."""
    c, s, up, level = math.cos(TURN), math.sin(TURN), math.sin(RISE), math.cos(RISE)
    seen: Float = points @ np.array([[-s, c, 0.0], [up * c, up * s, -level]]).T
    return seen

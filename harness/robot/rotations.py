"""How far one orientation is turned from another."""

import numpy as np

from harness.arrays import Float


def rotation_between(before: Float, after: Float) -> Float:
    """The turn that leads from one orientation to another, as a rotation vector in the world frame.

    Args:
        before: Rotation matrices R_world_tip, (n, 3, 3).
        after: The same.

    Returns:
        (n, 3), [rad]; the length is the angle between the two, in [0, pi], 0 only where they are alike.
    """
    from scipy.spatial.transform import Rotation  # takes as long to import as all of the core

    turn = after @ np.swapaxes(before, -1, -2)
    vector: Float = Rotation.from_matrix(turn).as_rotvec()
    return vector


def rotation_of_axes(axes: Float) -> Float:
    """Rotation matrices whose x and y axes are given, (n, 3, 3).

    Args:
        axes: The x axis, then the y axis, in the world frame, (n, 6). Where rounding has left them not quite of length
            1 and perpendicular, the nearest of that kind is taken, the x axis first.
    """
    x = axes[:, :3] / np.linalg.norm(axes[:, :3], axis=1, keepdims=True)
    y = axes[:, 3:] - np.vecdot(x, axes[:, 3:])[:, None] * x
    y /= np.linalg.norm(y, axis=1, keepdims=True)
    return np.stack([x, y, np.cross(x, y)], axis=2)


def axes_of_rotation(rotation: Float) -> Float:
    """The x axis, then the y axis of rotation matrices (n, 3, 3), in the world frame: (n, 6), a new array."""
    return np.concatenate([rotation[:, :, 0], rotation[:, :, 1]], axis=1)

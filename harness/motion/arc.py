"""The arc of a circle through three points."""

from dataclasses import dataclass

import numpy as np

from harness.arrays import Float

STRAIGHT = 1e-6
"""Three points whose triangle's area is below this share of its sides' product lie on a line."""


@dataclass(frozen=True, eq=False)
class Arc:
    """Ways from the origin along circles, or straight, for n arms at once.

    Attributes:
        forward: Unit vector in which a way begins; 0 where it is none, (n, 3).
        inward: Unit vector from the origin to the circle's centre; 0 where the way is straight, (n, 3).
        radius: (n, 1), [m]; 1 where the way is straight.
        length: Of the way, (n, 1), [m].
    """

    forward: Float
    inward: Float
    radius: Float
    length: Float

    def point(self, distance: Float) -> Float:
        """Where the ways are after `distance`, (n, 1) [m]: (n, 3), [m]."""
        angle = distance / self.radius
        straight = ~self.inward.any(axis=-1, keepdims=True)
        along = np.where(straight, distance, self.radius * np.sin(angle))
        # 1 - cos, exact also where the angle is small.
        point: Float = along * self.forward + 2.0 * self.radius * np.sin(0.5 * angle) ** 2 * self.inward
        return point


def arc_through(via: Float, end: Float) -> Arc:
    """The arcs from the origin through `via` to `end`, (n, 3) both, [m].

    Where the three lie on one line, or two of them coincide, the way is the straight line to `end`.
    """
    normal = np.cross(via, end)  # as long as the triangle's area, twice
    area, via_length, end_length = (np.linalg.norm(vector, axis=-1, keepdims=True) for vector in (normal, via, end))
    straight = area <= STRAIGHT * via_length * end_length
    area = np.where(straight, 1.0, area)
    center = np.cross(via_length**2 * end - end_length**2 * via, normal) / (2.0 * area**2)
    radius = np.where(straight, 1.0, np.linalg.norm(center, axis=-1, keepdims=True))
    inward = np.where(straight, 0.0, center / radius)
    line = end / np.where(end_length > 0.0, end_length, 1.0)
    forward = np.where(straight, line, np.cross(inward, normal / area))
    angle = np.arctan2(_dot(end, forward), radius - _dot(end, inward)) % (2.0 * np.pi)
    return Arc(forward, inward, radius, np.where(straight, end_length, radius * angle))


def _dot(first: Float, second: Float) -> Float:
    dot: Float = np.vecdot(first, second)[..., None]
    return dot

"""Spheres and boxes in an arm's way. A box stands along the world's axes.

An obstacle is `NUMBERS` numbers in the world frame, [m]: its centre (3), half edges (3; 0 of a sphere) and radius (0 of
a box). Seven zeros are no obstacle.
"""

import numpy as np

from harness.arrays import Float, Mask

NUMBERS = 7
CENTER, EDGES, RADIUS = slice(0, 3), slice(3, 6), 6
KINDS = {4: "sphere", 6: "box"}
"""By how many numbers a text gives."""


def parse_obstacles(text: str) -> Float:
    """Obstacles of a text such as ``0.5x0.1x0.6x0.08+0.6x-0.3x0.2x0.1x0.1x0.4``.

    Returns:
        (count, 7), see above.

    Raises:
        ValueError: It is something else.
    """
    return np.array([_obstacle(part) for part in text.split("+") if text]).reshape(-1, NUMBERS)


def _obstacle(text: str) -> list[float]:
    try:
        numbers = [float(word) for word in text.split("x")]
    except ValueError:
        numbers = []
    fits = len(numbers) in KINDS and np.isfinite(numbers).all() and min(numbers[3:]) > 0.0
    if not fits:
        raise ValueError(
            f"the obstacle '{text}' is neither a sphere, XxYxZxRADIUS, nor a box, XxYxZxAxBxC, with positive sizes"
        )
    if KINDS[len(numbers)] == "sphere":
        return [*numbers[:3], 0.0, 0.0, 0.0, numbers[3]]
    return [*numbers[:3], *(edge / 2.0 for edge in numbers[3:]), 0.0]


def there(obstacles: Float) -> Mask:
    """Which of (..., 7) are obstacles, (...,)."""
    some: Mask = np.any(obstacles[..., 3:] > 0.0, axis=-1, keepdims=True)[..., 0]
    return some


def distance_from(points: Float, obstacles: Float) -> Float:
    """From points, (..., 3), to the surfaces of obstacles, (..., 7): negative in a sphere, 0 in a box, (...,), [m]."""
    outside = np.maximum(np.abs(points - obstacles[..., CENTER]) - obstacles[..., EDGES], 0.0)
    distance: Float = np.sqrt(np.vecdot(outside, outside)) - obstacles[..., RADIUS]
    return distance


def seen_from(end_effector: Float, obstacles: Float, count: int) -> Float:
    """What a learner sees of obstacles: where they lie from the end effector, half edges and radius, the nearest first.

    Args:
        end_effector: (n, 3), world frame, [m].
        obstacles: (n, most, 7).
        count: So many are seen; zeros stand where there are fewer.

    Returns:
        (n, count, 7), [m].
    """
    distance = np.where(there(obstacles), distance_from(end_effector[:, None], obstacles), np.inf)
    nearest = np.argsort(distance, axis=1, kind="stable")[:, :count]
    chosen = np.take_along_axis(obstacles, nearest[..., None], axis=1)
    seen = np.zeros((len(obstacles), count, NUMBERS))
    seen[:, : chosen.shape[1]] = chosen
    seen[..., CENTER] -= np.where(there(seen)[..., None], end_effector[:, None], 0.0)
    return seen

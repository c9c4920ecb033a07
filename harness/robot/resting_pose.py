"""A resting pose for an arm that names none: simple, clear of the ground, away from singular poses."""

import itertools
from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from harness.arrays import Float
from harness.errors import UsageError
from harness.robot.ground_clearance import build_solids
from harness.robot.kinematics import Chain, end_effector_position, link_frames, position_jacobian
from harness.robot.shapes import Shape

BEND = 0.5
"""By how much a joint may leave the middle of its range, as a share of the way to its end."""
WIDEST_BEND = np.radians(45.0)
"""The most that a turning joint leaves the middle, [rad]."""
CLEARANCE = 0.1
"""The clearance of the moving links and the end effector over the ground, as a share of the chain's length."""
LOW_SHARE = 0.5
"""The share of how high they get at best, for links that are always low: those of a turret near the ground."""
LEAST_CLEARANCE = 2e-3
"""The least clearance of any of them, [m]: more than what engines add to shapes."""
HIGH = 1e6
"""The height of what has no shape, [m]."""
AGILITY = 0.5
"""How far from a singular pose, as a share of what the best of the poses has."""


def choose_home(
    chain: Chain, lower: Float, upper: Float, max_speed: Float, length: float, shapes: Sequence[Sequence[Shape]]
) -> Float:
    """The simplest pose that is clear of the ground and not close to a singular one.

    Looked at are the middle of all ranges and the poses in which some joints leave it half way to either end, turning
    ones by 45 degrees at most. Among those with the fewest joints off the middle that are high enough and agile
    enough, the most agile is taken, of equals the one with the tip farthest along +x. Agility is the tip's speed in
    its slowest direction when the joints, in the best combination, turn with their largest speeds.

    Args:
        chain: The arm, dof joints.
        lower: Of the ranges, [rad] or [m], (dof,).
        upper: Likewise.
        max_speed: [rad/s] or [m/s], (dof,).
        length: Of the chain, [m].
        shapes: Those that each joint moves, as `harness.robot.shapes.attach_shapes` returns them.

    Returns:
        Joint positions, (dof,).

    Raises:
        UsageError: All poses are too close to the ground.
    """
    middle, half = (lower + upper) / 2.0, (upper - lower) / 2.0
    bend = np.where(chain.slides, BEND * half, np.minimum(BEND * half, WIDEST_BEND))
    ways = np.array(list(itertools.product((0.0, 1.0, -1.0), repeat=chain.dof)))
    poses = middle + ways * bend
    agility = np.linalg.svd(position_jacobian(chain, poses) * max_speed, compute_uv=False)[:, -1]
    agile = agility >= AGILITY * agility.max()
    simple = poses[np.count_nonzero(ways, axis=1) <= 1]
    needed = _needed_heights(_heights(chain, shapes, simple), CLEARANCE * length)
    for level in _by_count(ways, agile):
        clear = level[(_heights(chain, shapes, poses[level]) >= needed).all(axis=0)]
        if clear.size:
            forward = end_effector_position(chain, poses[clear])[:, 0]
            # Rounded, so that poses which mirror one another are equal.
            best: Float = poses[clear[np.lexsort((forward.round(9), agility[clear].round(9)))[-1]]]
            return best
    raise UsageError(
        f"No simple pose keeps the moving links {CLEARANCE * length:.2g} m above the ground z = 0. "
        "Name one as home_deg (home_m of sliding joints) in a robot.toml beside the URDF, or raise the arm's base."
    )


def _by_count(ways: Float, agile: Float) -> Iterator[NDArray[np.intp]]:
    """Numbers of the agile poses, those with the fewest joints off the middle first."""
    counts = np.count_nonzero(ways, axis=1)
    for count in range(ways.shape[1] + 1):
        yield np.flatnonzero((counts == count) & agile)


def _needed_heights(simple: Float, clearance: float) -> Float:
    """How high the parts have to be, (dof + 1, 1), [m], by their heights in simple poses, (dof + 1, n)."""
    highest = simple.max(axis=1, keepdims=True)
    needed: Float = np.maximum(np.minimum(LOW_SHARE * highest, clearance), LEAST_CLEARANCE)
    return needed


def _heights(chain: Chain, shapes: Sequence[Sequence[Shape]], poses: Float) -> Float:
    """The heights of the lowest point of what each joint moves, and of the end effector, (dof + 1, n), [m]."""
    frames = link_frames(chain, poses)
    heights = np.full((chain.dof + 1, len(poses)), HIGH)
    for joint in range(chain.dof):
        alone = build_solids([group if number == joint else () for number, group in enumerate(shapes)])
        np.minimum(alone.lowest(frames), HIGH, out=heights[joint])
    heights[-1] = end_effector_position(chain, poses)[:, 2]
    return heights

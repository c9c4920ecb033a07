"""Where an arm rests that names no pose: in front of its mount, agile, and far from the ground for what it may do."""

import itertools
import math
from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from harness.arrays import Float, Mask
from harness.errors import UsageError
from harness.robot.ground_clearance import Solids, build_solids
from harness.robot.kinematics import Chain, end_effector_position, in_mount, link_frames, position_jacobian
from harness.robot.shapes import Shape

BEND = 0.5
"""By how much a joint may leave the middle of its range, as a share of the way to its end."""
BENDS = (math.radians(45.0), math.radians(90.0))
"""The most that a turning joint leaves the middle, [rad]: all joints by the first, as many as there is time for by
either, from the base on."""
MOST_POSES = 3**8
"""The most poses that are compared."""
MOST_TRIED = 128
"""The most of equal rank, the best, around which random actions are tried."""
CLEARANCE = 0.1
"""The clearance of the moving links and the end effector over the ground, as a share of the chain's length."""
LOW_SHARE = 0.5
"""The share of how high they get at best, for links that are always low: those of a turret near the ground."""
LEAST_CLEARANCE = 2e-3
"""The least clearance of any of them, [m]: more than what engines add to shapes."""
HIGH = 1e6
"""The height of what has no shape, [m]."""
AGILITY = 0.6
"""How far from a singular pose, as a share of what the best of the poses has."""
BEFORE = 0.25
"""How far the end effector is beside the first joint's origin, as a share of the chain's length."""
SECTOR = math.cos(math.radians(45.0))
"""It is before the mount if its direction is within 45 degrees of the x axis."""
DRIFT = 0.9
"""How far random actions take a joint from where an episode starts, in seconds at its largest speed."""
DRIFTS = 48
"""Poses around each one for which it is seen whether the arm is in the ground."""
STILL = 1e-6
"""An end effector this near to the last joint's axis does not move with it, [m]."""
PLAIN = 0.97
"""What is left of a pose's merit for each joint that is not in the middle."""
AT_ONCE = 16
"""Poses whose clearance is measured at once, the best first."""
DIRECTIONS = np.array([way for way in itertools.product((-1.0, 0.0, 1.0), repeat=3) if any(way)])
"""The points of a mesh that are farthest in one of these stand for it where random actions are tried."""


def choose_home(
    chain: Chain, lower: Float, upper: Float, max_speed: Float, length: float, shapes: Sequence[Sequence[Shape]]
) -> Float:
    """A pose in front of the mount, clear of the ground, not close to a singular pose, and not close to the ground.

    Compared are poses in which some joints leave the middle of their ranges half way to either end, turning ones by 45
    or 90 degrees at most. The first joint stays in the middle. Agility is the tip's speed in its slowest direction when
    the joints, in the best combination, turn with their largest speeds. The pose with the largest product is taken:
    agility, a factor for each joint off the middle, and the square of a share. Of poses around it, as far away as
    random actions lead in an episode, it is the share in which the arm is not in the ground. All this is seen in the
    frame of the mount, whose plane counts as ground: an arm on a wall rests as it does on the floor, if the ground is
    far enough away.

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
    ways = _ways(chain, lower, upper)
    poses = (lower + upper) / 2.0 + ways
    mounted = in_mount(chain)
    agility = _agility(mounted, poses, max_speed)
    rank, forward = _rank(mounted, poses, length, agility)
    bent = np.count_nonzero(ways, axis=1)
    merit = agility * PLAIN**bent
    solids = [build_solids([*[()] * joint, group]) for joint, group in enumerate(shapes)]
    rough = build_solids([[_rough(shape) if shape.kind == "mesh" else shape for shape in group] for group in shapes])
    is_on_floor = np.array_equal(chain.T_world_mount, np.eye(4))
    # A chain that hangs below the plane of its mount has the ground alone.
    for planes in ([chain],) if is_on_floor else ([mounted, chain], [chain]):
        needed = [_needed_heights(_heights(it, solids, poses[bent <= 1]), CLEARANCE * length) for it in planes]
        for level in _levels(rank, merit):
            around = _drifted(poses[level], lower, upper, max_speed)
            # Squared: an episode passes several such poses, and one in the ground ends it.
            safe = (merit[level] * _share_above(planes, rough, around) ** 2).round(9)
            best_first = level[np.lexsort((-forward[level], -safe))]
            for start in range(0, len(level), AT_ONCE):
                few = best_first[start : start + AT_ONCE]
                high = [_heights(it, solids, poses[few]) >= low for it, low in zip(planes, needed, strict=True)]
                clear = few[np.all(high, axis=(0, 1))]
                if clear.size:
                    best: Float = poses[clear[0]]
                    return best
    raise UsageError(
        f"No simple pose keeps the moving links {CLEARANCE * length:.2g} m above the ground z = 0. "
        "In a robot.toml, name one as home_deg (home_m of sliding joints), or raise the arm: "
        "base = { xyz_m = [0, 0, 1] }."
    )


def _ways(chain: Chain, lower: Float, upper: Float) -> Float:
    """By how much the poses to compare leave the middle of the ranges, (n, dof), the middle first."""
    half = (upper - lower) / 2.0
    small, wide = (np.where(chain.slides, BEND * half, np.minimum(BEND * half, most)) for most in BENDS)
    values = [[0.0, bend, -bend] for bend in small]
    if not chain.slides[0]:
        values[0] = [0.0]  # it turns the arm as a whole
    if not chain.slides[-1] and np.linalg.norm(np.cross(chain.axes[-1], chain.T_last_tip[:3, 3])) < STILL:
        values[-1] = [0.0]  # it does not move the end effector
    for joint in range(1, chain.dof - (len(values[-1]) == 1)):
        more = [*values[joint], wide[joint], -wide[joint]]
        count = math.prod(map(len, values)) // len(values[joint]) * len(more)
        if wide[joint] > small[joint] and count <= MOST_POSES:
            values[joint] = more
    return np.array(list(itertools.product(*values)))


def _agility(chain: Chain, poses: Float, max_speed: Float) -> Float:
    """The tip's speed in its slowest direction, rounded: poses that mirror one another are equal. [m/s], (n,)."""
    agility = np.linalg.svd(position_jacobian(chain, poses) * max_speed, compute_uv=False)[:, -1]
    return np.asarray(agility.round(9), np.float64)


def _rank(mounted: Chain, poses: Float, length: float, agility: Float) -> tuple[NDArray[np.intp], Float]:
    """The rank of each pose, the higher the better, and how far along x of the mount its tip is, [m], both (n,)."""
    way = end_effector_position(mounted, poses) - mounted.T_previous_joint[0, :3, 3]
    aside = np.hypot(way[:, 0], way[:, 1])
    is_beside = aside.round(9) >= BEFORE * length
    is_before = is_beside & (way[:, 0].round(9) >= (SECTOR * aside).round(9))
    is_agile = agility >= AGILITY * agility.max()
    return 3 * is_agile + np.add(is_beside, is_before, dtype=np.intp), way[:, 0].round(9)


def _levels(rank: NDArray[np.intp], merit: Float) -> Iterator[NDArray[np.intp]]:
    """Numbers of the poses of each rank, the best rank first; of many the best ones."""
    for value in sorted(set(rank.tolist()), reverse=True):
        level = np.flatnonzero(rank == value)
        yield level[np.argsort(-merit[level].round(9), kind="stable")][:MOST_TRIED]


def _drifted(poses: Float, lower: Float, upper: Float, max_speed: Float) -> Float:
    """Poses around each of the given ones, spread evenly, (n, DRIFTS, dof)."""
    steps = np.sqrt([2.0, 3.0, 5.0, 7.0, 11.0, 13.0, 17.0, 19.0])[: len(lower)]
    evenly = 2.0 * np.mod(np.arange(1, DRIFTS + 1)[:, None] * steps, 1.0) - 1.0
    drifted: Float = np.minimum(np.maximum(poses[:, None] + DRIFT * max_speed * evenly, lower), upper)
    return drifted


def _share_above(planes: Sequence[Chain], solids: Solids, poses: Float) -> Float:
    """The share of the poses around each one, (n, m, dof), in which the arm is above all planes, (n,)."""
    flat = poses.reshape(-1, poses.shape[-1])
    in_ground: Mask = np.zeros(len(flat), bool)
    for chain in planes:
        frames = link_frames(chain, flat)
        in_ground |= solids.touch_ground(frames) | (_tip_height(chain, frames) < 0.0)
    above: Float = 1.0 - in_ground.reshape(poses.shape[:2]).mean(axis=1)
    return above


def _rough(mesh: Shape) -> Shape:
    return replace(mesh, points=mesh.points[np.unique(np.argmax(mesh.points @ DIRECTIONS.T, axis=0))])


def _needed_heights(simple: Float, clearance: float) -> Float:
    """How high the parts have to be, (dof + 1, 1), [m], by their heights in simple poses, (dof + 1, n)."""
    highest = simple.max(axis=1, keepdims=True)
    needed: Float = np.maximum(np.minimum(LOW_SHARE * highest, clearance), LEAST_CLEARANCE)
    return needed


def _heights(chain: Chain, solids: Sequence[Solids], poses: Float) -> Float:
    """The heights of the lowest point of what each joint moves, and of the end effector, (dof + 1, n), [m]."""
    frames = link_frames(chain, poses)
    lowest = [np.minimum(alone.lowest(frames), HIGH) for alone in solids]
    return np.stack([*lowest, _tip_height(chain, frames)])


def _tip_height(chain: Chain, frames: Float) -> Float:
    """The end effector's height where `link_frames` has been computed, [m], (n,)."""
    up, tip = frames[-1, 2], chain.T_last_tip[:3, 3]
    height: Float = up[0] * tip[0] + up[1] * tip[1] + up[2] * tip[2] + up[3]
    return height

"""How far and how quickly each joint may move, and where it rests.

These numbers are those of `robot.toml`, or of the URDF by fixed rules where it has none.
"""

import itertools
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from harness.arrays import Float
from harness.errors import UsageError
from harness.robot.ground_clearance import build_solids
from harness.robot.kinematics import (
    Chain,
    chain_length,
    end_effector_position,
    link_frames,
    position_jacobian,
    read_only,
)
from harness.robot.settings import FILE, JOINT_KEYS, Motion, Quantity, RobotSettings, motion_of, shown, toml_key
from harness.robot.shapes import Shape
from harness.robot.urdf import Joint

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
        "Name one as home_deg (home_m of sliding joints) in a robot.toml, or raise the arm's base."
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


LARGEST_DEFAULT_SPEED = {"turning": math.radians(180.0), "sliding": 1.0}
"""[rad/s] and [m/s]. Where a URDF allows more and robot.toml says nothing, it seldom is the arm's: 10 rad/s for 2."""
EXAMPLE_SPEED: Mapping[Motion, str] = {"turning": "90", "sliding": "0.2"}
"""What a message shows as the value of a key."""
SPEED_UP_RATE = 8.0
"""Largest acceleration by largest speed, [1/s], where robot.toml has none: full speed in an eighth of a second."""
RULES = {
    "home": "the simplest pose clear of the ground and of singular poses",
    "max_speed": "the URDF's velocity, at most 180 deg/s or 1 m/s",
    "max_acceleration": "the largest speed in an eighth of a second",
}


@dataclass(frozen=True, eq=False)
class RobotLimits:
    """What `harness.robot.robot.Robot` has of the same names: read-only float64 of shape (dof,)."""

    lower: Float
    upper: Float
    max_speed: Float
    max_acceleration: Float
    home: Float


def read_joint_limits(
    settings: RobotSettings,
    urdf: Path,
    driven: Sequence[Joint],
    chain: Chain,
    shapes: Sequence[Sequence[Shape]],
    own_home: Mapping[str, float] = MappingProxyType({}),
) -> RobotLimits:
    """The limits of the joints that move, and the resting pose.

    Args:
        settings: The robot.toml.
        urdf: The URDF's file, for what an error begins with.
        driven: The joints, dof of them.
        chain: The same.
        shapes: Those that each of them moves.
        own_home: Positions by joint where the arm's file has a resting pose; of it what robot.toml leaves out is taken.

    Raises:
        UsageError: A number is not given, or cannot be; the message starts with the file to correct.
    """
    # One turn where a joint has no end, so that every range is finite.
    lower = _array([-math.pi if joint.kind == "continuous" else joint.lower for joint in driven])
    upper = _array([math.pi if joint.kind == "continuous" else joint.upper for joint in driven])
    max_speed = _max_speed(settings, urdf, driven)
    max_acceleration = _fill(settings.values("max_acceleration", driven), SPEED_UP_RATE * max_speed)
    _check_positive(settings, "max_acceleration", driven, max_acceleration)
    home = [
        own_home.get(joint.name) if value is None else value
        for joint, value in zip(driven, settings.values("home", driven), strict=True)
    ]
    resting = lower if None not in home else _choose_home(urdf, chain, lower, upper, max_speed, shapes)
    limits = RobotLimits(lower, upper, max_speed, max_acceleration, _fill(home, resting))
    _check_home(settings, driven, limits)
    return limits


def _choose_home(
    urdf: Path, chain: Chain, lower: Float, upper: Float, max_speed: Float, shapes: Sequence[Sequence[Shape]]
) -> Float:
    try:
        return choose_home(chain, lower, upper, max_speed, chain_length(chain, lower, upper), shapes)
    except UsageError as error:
        raise UsageError(f"{urdf}: {error}") from error


def describe_origin(settings: RobotSettings, quantity: Quantity, driven: Sequence[Joint]) -> str:
    """Where the numbers of all joints come from, in words."""
    missing = [value is None for value in settings.values(quantity, driven)]
    if not any(missing):
        return FILE
    return RULES[quantity] if all(missing) else f"{FILE}, else {RULES[quantity]}"


def _max_speed(settings: RobotSettings, urdf: Path, driven: Sequence[Joint]) -> Float:
    given = settings.values("max_speed", driven)
    lacking = [joint for joint, value in zip(driven, given, strict=True) if value is None and joint.velocity is None]
    if lacking:
        raise UsageError(f"{urdf}: {_speeds_wanted(settings, driven, lacking)}")
    default = [min(joint.velocity or math.inf, LARGEST_DEFAULT_SPEED[motion_of(joint)]) for joint in driven]
    speed = _fill(given, np.array(default))
    _check_positive(settings, "max_speed", driven, speed)
    return speed


def warn_of_speeds(driven: Sequence[Joint], max_speed: Float) -> list[str]:
    """A line where robot.toml allows joints more than the URDF, which it may: a velocity there is often a placeholder.

    Args:
        driven: The joints, dof of them.
        max_speed: What they are allowed, [rad/s] or [m/s], (dof,).
    """
    above = [
        f"joint '{joint.name}' {shown(value, joint)} {_unit(joint)}, the URDF {shown(joint.velocity, joint)}"
        for joint, value in zip(driven, max_speed, strict=True)
        if joint.velocity is not None and value > joint.velocity * (1.0 + 1e-6)  # equal up to rounding is fine
    ]
    return [f"{FILE} allows {'; '.join(above)}"] * bool(above)


def _unit(joint: Joint) -> str:
    return "m/s" if motion_of(joint) == "sliding" else "deg/s"


def _speeds_wanted(settings: RobotSettings, driven: Sequence[Joint], lacking: Sequence[Joint]) -> str:
    """What to write for joints that have no speed limit; short enough for a line that is cut at 300 characters."""
    lines = []
    for motion, key in JOINT_KEYS["max_speed"].items():
        names = [joint.name for joint in lacking if motion_of(joint) == motion]
        example = EXAMPLE_SPEED[motion]
        if len(names) == sum(motion_of(joint) == motion for joint in driven):
            lines += [f"{key} = [{', '.join([example] * len(names))}]"] * bool(names)
        elif names:
            lines += [f"{key} = {{ {', '.join(f'{toml_key(name)} = {example}' for name in names)} }}"]
    more = f" and {len(lacking) - 1} more" * (len(lacking) > 1)
    told = f"joint '{lacking[0].name}'{more}: no velocity limit above 0."
    return f"{told} Write into {settings.to_write}, with the arm's own numbers: {' and '.join(lines)}"


def _check_positive(settings: RobotSettings, quantity: Quantity, driven: Sequence[Joint], values: Float) -> None:
    for joint, value in zip(driven, values, strict=True):
        if value <= 0.0:
            raise UsageError(f"{_place(settings, quantity, joint)} is {shown(value, joint)}. Give a positive value.")


def _check_home(settings: RobotSettings, driven: Sequence[Joint], limits: RobotLimits) -> None:
    for joint, low, value, high in zip(driven, limits.lower, limits.home, limits.upper, strict=True):
        if not low <= value <= high:
            allowed = f"{shown(low, joint)} to {shown(high, joint)}"
            raise UsageError(
                f"{_place(settings, 'home', joint)} is {shown(value, joint)}; allowed: {allowed}. Correct it."
            )


def _place(settings: RobotSettings, quantity: Quantity, joint: Joint) -> str:
    return f"{settings.path}: {JOINT_KEYS[quantity][motion_of(joint)]} of '{joint.name}'"


def _fill(given: Sequence[float | None], default: Float) -> Float:
    """The values given, and the default ones where there is none."""
    return _array([other if value is None else value for value, other in zip(given, default, strict=True)])


def _array(values: Sequence[float]) -> Float:
    return read_only(np.array(values, dtype=np.float64))

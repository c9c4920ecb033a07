"""How far and how quickly each joint may move, and where it rests.

These numbers are those of `robot.toml`, or of the URDF by fixed rules where it has none.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType

import numpy as np

from harness.arrays import Float
from harness.errors import UsageError
from harness.robot.kinematics import Chain, chain_length, read_only
from harness.robot.resting_pose import choose_home
from harness.robot.settings import FILE, JOINT_KEYS, Motion, Quantity, RobotSettings, motion_of, shown, toml_key
from harness.robot.shapes import Shape
from harness.robot.urdf import Joint

LARGEST_DEFAULT_SPEED = math.radians(180.0)
"""[rad/s]. Where a URDF allows more and robot.toml says nothing, it seldom is the arm's: 10 rad/s for 2."""
LARGEST_DEFAULT_SHARE = 0.5
"""The same for a joint that slides: as a share of its range, [1/s]. Half a turn is so much of a turning joint's."""
EXAMPLE_SPEED: Mapping[Motion, str] = {"turning": "90", "sliding": "0.2"}
"""What a message shows as the value of a key."""
SPEED_UP_RATE = 8.0
"""Largest acceleration by largest speed, [1/s], where robot.toml has none: full speed in an eighth of a second."""
RULES = {
    "home": "a pose in front of the mount, far from the ground and from singular poses",
    "max_speed": "the URDF's velocity, at most 180 deg/s, or half a slide's range a second",
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
    max_speed = _max_speed(settings, urdf, driven, upper - lower)
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


def _max_speed(settings: RobotSettings, urdf: Path, driven: Sequence[Joint], span: Float) -> Float:
    given = settings.values("max_speed", driven)
    lacking = [joint for joint, value in zip(driven, given, strict=True) if value is None and joint.velocity is None]
    if lacking:
        raise UsageError(f"{urdf}: {_speeds_wanted(settings, driven, lacking)}")
    slides = [motion_of(joint) == "sliding" for joint in driven]
    largest = np.where(slides, LARGEST_DEFAULT_SHARE * span, LARGEST_DEFAULT_SPEED)
    speed = _fill(given, np.minimum([joint.velocity or math.inf for joint in driven], largest))
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

"""What ``robot.toml`` says of the joints: their limits, where they rest, and the servos that drive them."""

import hashlib
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from types import MappingProxyType
from typing import Literal, get_args

import numpy as np
from numpy.typing import ArrayLike

from harness.arrays import Float
from harness.errors import UsageError
from harness.robot.kinematics import Chain, chain_length, read_only
from harness.robot.resting_pose import choose_home
from harness.robot.settings import FILE, JOINT_KEYS, SERVO, Motion, Quantity, RobotSettings, motion_of, shown, toml_key
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
    "max_speed": "the velocity in the arm's file if it has one, at most 180 deg/s, or half a slide's range a second",
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
    resting = lower
    if None in home:
        try:
            resting = choose_home(chain, lower, upper, max_speed, chain_length(chain, lower, upper), shapes)
        except UsageError as error:
            raise UsageError(f"{urdf}: {error}") from error
    limits = RobotLimits(lower, upper, max_speed, max_acceleration, _fill(home, resting))
    _check_home(settings, driven, limits)
    return limits


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
        f"joint '{joint.name}' {shown(value, joint)} {'m/s' if joint.kind == 'prismatic' else 'deg/s'}, the URDF "
        f"{shown(joint.velocity, joint)}"
        for joint, value in zip(driven, max_speed, strict=True)
        if joint.velocity is not None and value > joint.velocity * (1.0 + 1e-6)  # equal up to rounding is fine
    ]
    return [f"{FILE} allows {'; '.join(above)}"] * bool(above)


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


Part = Literal["max_torque", "armature", "viscous_friction", "dry_friction", "stiffness", "damping"]
PART_KEYS: Mapping[Part, Mapping[Motion, str]] = {
    "max_torque": {"turning": "max_torque_nm", "sliding": "max_force_n"},
    "armature": {"turning": "armature_kg_m2", "sliding": "armature_kg"},
    "viscous_friction": {"turning": "viscous_friction_nms_per_rad", "sliding": "viscous_friction_ns_per_m"},
    "dry_friction": {"turning": "dry_friction_nm", "sliding": "dry_friction_n"},
    "stiffness": {"turning": "stiffness_nm_per_rad", "sliding": "stiffness_n_per_m"},
    "damping": {"turning": "damping_nms_per_rad", "sliding": "damping_ns_per_m"},
}
"""The keys of `[servo]` that hold one value per joint of a motion, in the order of the chain."""
FRICTIONS: tuple[Part, ...] = ("viscous_friction", "dry_friction")
"""0 where they are left out; of the others only `max_torque` may be, where the URDF has an effort above 0."""
POSITIVE: tuple[Part, ...] = ("max_torque", "stiffness")
LATENCY, GRAVITY = "latency_s", "gravity_compensated"
KEYS = (*(key for keys in PART_KEYS.values() for key in keys.values()), LATENCY, GRAVITY)


@dataclass(frozen=True, eq=False)
class Servo:
    """The drives of an arm's joints, the same in every simulator.

    `harness.simulator.Simulation.drive` moves a reference at constant speed from the last commanded target, not from
    where the joint is, to the new one; after a reset the last target is the pose that was reset to. At the begin of
    each physics step the drive of a joint has the torque

        torque = clip(stiffness (q_ref - q) + damping (v_ref - v) + g(q), -max_torque, max_torque)

    with the joint's position q and speed v, and the reference's q_ref and v_ref as they were `latency` earlier. g(q) is
    the torque that holds the arm against its weight, or 0 where gravity is not compensated: holding the weight takes
    its part of the limit. The torque stays as it is until the next physics step. Viscous friction -viscous_friction v
    and dry friction, which holds the joint still or slows it down with at most dry_friction, act beside it and do not
    count against the limit. `armature` is added to the joint's own entry of the joint-space inertia.

    All arrays are read-only float64 of shape (dof,), >= 0. Where a joint slides, read N for N m, m for rad and kg for
    kg m^2.

    Attributes:
        max_torque: Largest torque of the drive at the joint, either way, positive [N m].
        armature: Inertia of motor and gear, seen at the joint [kg m^2].
        viscous_friction: Torque per speed [N m s/rad].
        dry_friction: Torque at any speed, Coulomb's [N m].
        stiffness: Torque per position error, positive [N m/rad].
        damping: Torque per speed error [N m s/rad].
        latency: From a command until the drive follows it, >= 0 [s].
        gravity_compensated: Whether the drive holds the arm's weight by itself.
    """

    max_torque: Float
    armature: Float
    viscous_friction: Float
    dry_friction: Float
    stiffness: Float
    damping: Float
    latency: float
    gravity_compensated: bool

    @cached_property
    def digest(self) -> str:
        """SHA-256 of all these numbers."""
        parts = np.stack([getattr(self, part) for part in get_args(Part)])
        rest = f"{self.latency!r} {self.gravity_compensated}"
        return hashlib.sha256(parts.tobytes() + rest.encode()).hexdigest()

    def delay(self, timestep: float) -> int:
        """Physics steps of `timestep` [s] in the latency, rounded to the nearest whole number; halves go up."""
        return math.floor(self.latency / timestep + 0.5)

    def torque(
        self, qpos: ArrayLike, qvel: ArrayLike, qpos_ref: ArrayLike, qvel_ref: ArrayLike, gravity: ArrayLike = 0.0
    ) -> Float:
        """What the drives do in a physics step, within plus and minus `max_torque`.

        Args:
            qpos: Joint positions at the begin of the step [rad], shape (..., dof).
            qvel: Joint speeds at the begin of the step [rad/s], shape (..., dof).
            qpos_ref: The references' positions, `latency` ago [rad], shape (..., dof).
            qvel_ref: The references' speeds, `latency` ago [rad/s], shape (..., dof).
            gravity: Torques that hold the arm's weight at `qpos` [N m], shape (..., dof); taken only where gravity is
                compensated.

        Returns:
            [N m], shape (..., dof), a new array.
        """
        error = self.stiffness * np.subtract(qpos_ref, qpos) + self.damping * np.subtract(qvel_ref, qvel)
        wanted = np.add(error, gravity) if self.gravity_compensated else error
        clipped: Float = np.clip(wanted, -self.max_torque, self.max_torque)
        return clipped


def read_servo(settings: RobotSettings, joints: Sequence[Joint]) -> Servo | None:
    """The drives that `[servo]` describes; None where there is no such table.

    Args:
        settings: The robot.toml.
        joints: Those that move, in the order of the chain.

    Raises:
        UsageError: A key is unknown or missing, or a number cannot be; the message starts with the file.
    """
    table = settings.table(SERVO, KEYS)
    if table is None:
        return None
    latency, is_compensated = table.number(LATENCY, 0.0), table.entries.get(GRAVITY, True)
    if latency < 0.0:
        raise UsageError(f"{table.place}: {LATENCY} is {latency:g}. Give 0 or more.")
    if not isinstance(is_compensated, bool):
        raise UsageError(f"{table.place}: {GRAVITY} is {is_compensated!r:.100}. Give true or false.")
    parts = {part: _read_part(table, part, joints) for part in get_args(Part)}
    return Servo(**parts, latency=latency, gravity_compensated=is_compensated)


def _read_part(table: RobotSettings, part: Part, joints: Sequence[Joint]) -> Float:
    values = []
    for joint, given in zip(joints, table.numbers(PART_KEYS[part], joints), strict=True):
        value = joint.effort if given is None and part == "max_torque" else given
        key = PART_KEYS[part][motion_of(joint)]
        if value is None and part not in FRICTIONS:
            raise UsageError(
                f"{table.place}: missing {key} of '{joint.name}'. Give one value per {motion_of(joint)} joint."
            )
        number = value or 0.0
        if number < 0.0 or (part in POSITIVE and not number):
            allowed = "a positive value" if part in POSITIVE else "0 or more"
            raise UsageError(f"{table.place}: {key} of '{joint.name}' is {number:g}. Give {allowed}.")
        values.append(number)
    return read_only(np.array(values, dtype=np.float64))

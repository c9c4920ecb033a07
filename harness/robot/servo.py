"""What moves the joints of a real arm: drives with limits, `[servo]` in `robot.toml`; docs/drives.md."""

import hashlib
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Literal, get_args

import numpy as np
from numpy.typing import ArrayLike

from harness.arrays import Float
from harness.errors import UsageError
from harness.robot.kinematics import read_only
from harness.robot.settings import SERVO, Motion, RobotSettings, motion_of
from harness.robot.urdf import Joint

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
    parts = {part: _read_part(table, part, joints) for part in get_args(Part)}
    return Servo(**parts, latency=_read_latency(table), gravity_compensated=_read_gravity(table))


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


def _read_latency(table: RobotSettings) -> float:
    latency = table.number(LATENCY, 0.0)
    if latency < 0.0:
        raise UsageError(f"{table.place}: {LATENCY} is {latency:g}. Give 0 or more.")
    return latency


def _read_gravity(table: RobotSettings) -> bool:
    given = table.entries.get(GRAVITY, True)
    if not isinstance(given, bool):
        raise UsageError(f"{table.place}: {GRAVITY} is {given!r:.100}. Give true or false.")
    return given

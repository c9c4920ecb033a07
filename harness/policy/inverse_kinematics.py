"""The arm's own kinematics as a policy."""

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any, ClassVar, Self, cast

import numpy as np

from harness.arrays import Float, Float32
from harness.motion.motion import JointLimits
from harness.policy.policy import LARGEST, Policy, Uniform
from harness.robot import Robot
from harness.robot.kinematics import Chain, chain_length, reach_pose, reach_position, rotation_of_axes
from harness.robot.urdf import JointKind

MODES = ("movej", "movej-absolute", "set-joints")
"""Action modes that it acts in; see `harness.motion`."""

KINDS = ("revolute", "continuous", "prismatic")
LONGEST_PERIOD = 1e3
"""[s]; ours is a fiftieth."""
SHAPES = {"joints": (4, 4), "axes": (3,), "lower": (), "upper": (), "max_speed": (), "max_change": ()}
"""The shape of each array's part for one joint."""


@dataclass(frozen=True, eq=False)
class InverseKinematics(Policy):
    """Finds joint positions that bring the end effector to the target, and goes there as fast as the joints can.

    Acts on the observations of `harness.env.arm_observation.ArmObservation`, and of
    `harness.env.arm_observation.GoalObservation`: it goes to where the target is now.

    All that it needs to know of the arm is in its arrays: no robot's file is read, and a robot that has changed since
    changes nothing.

    Attributes:
        weights: ``joints`` (dof, 4, 4), ``axes`` (dof, 3) and ``tip`` (4, 4) of the `harness.robot.kinematics.Chain`;
            ``lower``, ``upper``, ``max_speed`` and ``max_change`` (dof,) of the `harness.motion.motion.JointLimits`.
        joint_kinds: How each joint moves, as in the chain.
        mode: The action mode, one of `MODES`.
        period: Control period, [s].
        robot: Name of the arm and the SHA-256 of its URDF, for the reader of the card.
        algorithm: The same.
        more: How many numbers the observation has beside those of `ArmObservation`.
        turns: Whether it also brings the end effector into the target's orientation, whose x and y axis are then the
            first six of them.
    """

    kind: ClassVar[str] = "inverse-kinematics"

    weights: Mapping[str, Float32]
    joint_kinds: tuple[str, ...]
    mode: str
    period: float
    robot: Mapping[str, str]
    algorithm: str = ""
    more: int = 0
    turns: bool = False

    @classmethod
    def of(
        cls, robot: Robot, limits: JointLimits, mode: str, algorithm: str = "", more: int = 0, turns: bool = False
    ) -> Self:
        """For an arm within the limits of a task."""
        chain = robot.chain
        numbers = {
            "joints": chain.T_previous_joint,
            "axes": chain.axes,
            "tip": chain.T_last_tip,
            "lower": robot.lower,
            "upper": robot.upper,
            "max_speed": limits.max_speed,
            "max_change": limits.max_change,
        }
        named = {"name": robot.name, "urdf_sha256": hashlib.sha256(robot.urdf.encode()).hexdigest()}
        weights = {name: array.astype(np.float32) for name, array in numbers.items()}
        return cls(weights, tuple(chain.kinds), mode, limits.period, named, algorithm, more, turns)

    def act(self, observation: Float32, rng: np.random.Generator | None = None) -> Float32:
        """See `harness.policy.policy.Policy.act`; there is one action for each observation, drawn or not."""
        dof, limits = len(self.joint_kinds), self._limits
        seen = np.asarray(observation, np.float64)
        qpos = limits.position(seen[:, :dof])
        # An arm that has no such pose goes as near as the search came.
        place, axes = seen[:, 3 * dof : 3 * dof + 3], seen[:, 3 * dof + 10 : 3 * dof + 16]
        if self.turns:
            goal, _ = reach_pose(self._arm, place, rotation_of_axes(axes), qpos)
        else:
            goal, _ = reach_position(self._arm, place, qpos)
        action = self._speed(goal - qpos) / limits.max_speed if self.mode == "movej" else limits.normalised(goal)
        clipped: Float32 = np.clip(action, -1.0, 1.0).astype(np.float32)
        return clipped

    def floor(self) -> Uniform:
        return Uniform((-1.0,) * len(self.joint_kinds), (1.0,) * len(self.joint_kinds))

    def card(self) -> dict[str, Any]:
        dof = len(self.joint_kinds)
        return {
            "observation": {"size": 3 * dof + 10 + self.more},
            **({"turns": True} if self.turns else {}),
            "action": {"type": "continuous", "low": [-1.0] * dof, "high": [1.0] * dof},
            "joint_kinds": list(self.joint_kinds),
            "mode": self.mode,
            "period": self.period,
            "robot": dict(self.robot),
        }

    @classmethod
    def from_card(cls, card: Mapping[str, Any], weights: Mapping[str, Float32]) -> Self:
        kinds = tuple(card["joint_kinds"])
        if not kinds or not set(kinds) <= set(KINDS):
            raise ValueError(f"no arm has the joints {kinds}")
        if card["mode"] not in MODES:
            raise ValueError(f"no action mode {card['mode']!r}; there is: {', '.join(MODES)}")
        period = float(card["period"])
        if not 0.0 < period <= LONGEST_PERIOD:
            raise ValueError(f"the period is {period} s, not above 0 and at most {LONGEST_PERIOD:g} s")
        for name, shape in {**{name: (len(kinds), *part) for name, part in SHAPES.items()}, "tip": (4, 4)}.items():
            if weights[name].shape != shape or not (np.abs(weights[name]) <= LARGEST).all():  # NaN is not either
                raise ValueError(f"{name} is {weights[name].shape}, not finite numbers {shape}")
        lower, upper, speed, change = (weights[name] for name in ("lower", "upper", "max_speed", "max_change"))
        if not ((lower <= upper) & (speed > 0.0) & (change > 0.0)).all():
            raise ValueError("a joint has no range, no speed or no acceleration")
        robot = {str(key): str(value) for key, value in card["robot"].items()}
        more, turns = int(card["observation"]["size"]) - (3 * len(kinds) + 10), bool(card.get("turns", False))
        if more < (6 if turns else 0):
            raise ValueError(f"an observation of {card['observation']['size']} numbers tells no target of this arm")
        return cls(weights, kinds, card["mode"], period, robot, card["algorithm"], more, turns)

    def _speed(self, room: Float) -> Float:
        """Speeds, (n, dof), that end the way `room` in this period, or are as high as stopping at its end allows."""
        limits = self._limits
        fastest = np.minimum(limits.stopping_speed(np.abs(room)), limits.max_speed)
        return np.copysign(fastest, room)

    @cached_property
    def _limits(self) -> JointLimits:
        lower, upper, speed, change = map(self._exact, ("lower", "upper", "max_speed", "max_change"))
        return JointLimits(lower, upper, speed, change, self.period)

    @cached_property
    def _arm(self) -> "KnownArm":
        joints, axes, tip, lower, upper = map(self._exact, ("joints", "axes", "tip", "lower", "upper"))
        kinds = cast(tuple[JointKind, ...], self.joint_kinds)
        return KnownArm(Chain(joints, axes, kinds, tip), lower, upper)

    def _exact(self, name: str) -> Float:
        return self.weights[name].astype(np.float64)


@dataclass(frozen=True, eq=False)
class KnownArm:
    """What a search for joint positions has to know of an arm; see `harness.robot.kinematics.Arm`."""

    chain: Chain
    lower: Float
    upper: Float

    @cached_property
    def reach(self) -> float:
        """The arm's reach, as `harness.robot.Robot` has it."""
        return chain_length(self.chain, self.lower, self.upper)

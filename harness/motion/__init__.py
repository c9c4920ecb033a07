"""Motion commands, NOTE Table II: how an action becomes joint targets within the robot's limits."""

from harness.motion.discrete import Discrete
from harness.motion.modes import MODES, build_motion
from harness.motion.motion import JointLimits, Motion, Move, MoveJ, MoveJAbsolute, SetJoints, Setting

__all__ = [
    "MODES",
    "Discrete",
    "JointLimits",
    "Motion",
    "Move",
    "MoveJ",
    "MoveJAbsolute",
    "SetJoints",
    "Setting",
    "build_motion",
]

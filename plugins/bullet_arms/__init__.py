"""Arms in Bullet's worlds, and frames of them: what the simulator `pybullet` is made of."""

from .arm import Arm, turn_alone
from .free_arm import FreeArm
from .scene import Scene
from .servo_arm import ServoArm
from .world import connect, exact_timestep, set_steps

__all__ = ["Arm", "FreeArm", "Scene", "ServoArm", "connect", "exact_timestep", "set_steps", "turn_alone"]

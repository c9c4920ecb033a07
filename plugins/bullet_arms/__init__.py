"""Arms in Bullet's worlds, and frames of them: the parts of the simulator `pybullet`."""

from .arm import Arm
from .arm_file import file_of_arm
from .clients import Clients
from .free_arm import FreeArm
from .servo_arm import ServoArm
from .world import exact_timestep

__all__ = ["Arm", "Clients", "FreeArm", "ServoArm", "exact_timestep", "file_of_arm"]

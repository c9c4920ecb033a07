"""What the simulators on MuJoCo's engine share: the engine, the model of an arm, and frames of it."""

from .arms import Batch, OneArm, RampFeed, ServoFeed  # first, so that `engine` is what imports MuJoCo
from .engine import import_engine, mujoco
from .model import GROUND, TARGET, TOUCH, build_model
from .rendering import Renderer

__all__ = [
    "GROUND",
    "TARGET",
    "TOUCH",
    "Batch",
    "OneArm",
    "RampFeed",
    "Renderer",
    "ServoFeed",
    "build_model",
    "import_engine",
    "mujoco",
]

"""What the simulators on MuJoCo's engine share: the engine, the model of an arm, and its frames."""

from .engine import import_engine, mujoco  # first: the others import MuJoCo as it is then
from .model import GROUND, TARGET, TOUCH, build_model
from .rendering import Renderer

__all__ = ["GROUND", "TARGET", "TOUCH", "Renderer", "build_model", "import_engine", "mujoco"]

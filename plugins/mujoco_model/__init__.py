"""What the simulators on MuJoCo's engine share: the engine, the model of an arm, and its frames."""

from harness_plugins.mujoco_model.engine import import_engine, mujoco  # first: the others import MuJoCo as it is then
from harness_plugins.mujoco_model.model import GROUND, TARGET, TOUCH, build_model
from harness_plugins.mujoco_model.rendering import Renderer

__all__ = ["GROUND", "TARGET", "TOUCH", "Renderer", "build_model", "import_engine", "mujoco"]

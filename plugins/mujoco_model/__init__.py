"""What the simulators on MuJoCo's engine share: the model of an arm."""

from .model import GROUND, TARGET, TOUCH, build_model

__all__ = ["GROUND", "TARGET", "TOUCH", "build_model"]

"""Reach tasks of other projects, as their authors publish them. `harness bench` compares our speed with theirs.

Both do 20 physics steps per env step. Neither can step several arms at once.
"""

from importlib import import_module
from importlib.util import find_spec
from typing import Any

import gymnasium

from harness.errors import UsageError


class _PlainEnums:
    """The module `mujoco`, with plain integers in place of the members of its enum ``mjtJoint``.

    Since mujoco 3.12 a number from an array is not found in a tuple of enum members. Gymnasium-Robotics 1.4.2 looks for
    it there, so its FetchReach cannot be made with a newer mujoco.
    """

    def __init__(self, mujoco: Any) -> None:
        self._mujoco = mujoco
        members = mujoco.mjtJoint.__members__
        self.mjtJoint = type("mjtJoint", (), {name: int(value) for name, value in members.items()})

    def __getattr__(self, name: str) -> Any:
        return getattr(self._mujoco, name)


def panda_reach() -> Any:
    """``PandaReach-v3`` of panda-gym, on PyBullet.

    Raises:
        UsageError: panda-gym is not installed.
    """
    _require("panda_gym")
    return gymnasium.make("PandaReach-v3")


def fetch_reach() -> Any:
    """``FetchReach-v4`` of Gymnasium-Robotics, on MuJoCo.

    From the first call on, that library's module uses `_PlainEnums` in place of `mujoco`.

    Raises:
        UsageError: Gymnasium-Robotics is not installed.
    """
    _require("gymnasium_robotics")
    module: Any = import_module("gymnasium_robotics.utils.mujoco_utils")
    if not isinstance(module.mujoco, _PlainEnums):  # the env uses it when it is made and in every step
        module.mujoco = _PlainEnums(module.mujoco)
    return gymnasium.make("FetchReach-v4")


def _require(package: str) -> None:
    if find_spec(package) is None:
        raise UsageError(f"{package} is not installed: pip install 'fd100-harness[peers]'")
    gymnasium.register_envs(import_module(package))

"""Imports MuJoCo in such a way that arms move even if rendering does not work."""

import importlib
import os
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from types import ModuleType

__all__ = ["choices_kept", "import_engine", "mujoco"]

CHOICES = ("MUJOCO_GL", "PYOPENGL_PLATFORM")
"""Environment variables that say which library renders."""


def import_engine(name: str) -> ModuleType:
    """Import `mujoco`, or a library that builds on it.

    While MuJoCo and dm_control are imported, they load the rendering library that MUJOCO_GL names. If that is missing,
    they cannot be imported. They are then imported without a rendering library, since a training renders nothing.
    """
    with choices_kept():
        try:
            with warnings.catch_warnings():
                # Without a screen GLFW only warns, so dm_control would choose it. After an error dm_control tries EGL
                # and OSMesa.
                warnings.filterwarnings("error", category=UserWarning, module="glfw")
                return importlib.import_module(name)
        except (AttributeError, ImportError, OSError, RuntimeError):  # the GL libraries raise any of these
            os.environ["MUJOCO_GL"] = "off"
            return importlib.import_module(name)  # raises the error again if it has another cause


@contextmanager
def choices_kept() -> Iterator[None]:
    """Undo what the block does to the variables in `CHOICES`, so that later processes choose for themselves."""
    kept = {name: os.environ.get(name) for name in CHOICES}
    try:
        yield
    finally:
        for name, value in kept.items():
            os.environ.pop(name, None)
            if value is not None:
                os.environ[name] = value


import_engine("mujoco")
import mujoco  # noqa: E402 (the simulators get it from here)

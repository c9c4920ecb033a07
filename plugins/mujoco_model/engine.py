"""MuJoCo, imported in a way that nothing about rendering can keep an arm from moving."""

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
    """Import `mujoco`, or what builds on it.

    Both MuJoCo and dm_control load the library that MUJOCO_GL names while they are imported, and cannot be imported
    where it is missing. They are then imported without one: a training renders nothing.
    """
    with choices_kept():
        try:
            with warnings.catch_warnings():
                # Without a screen GLFW only warns, and dm_control would take it; an error makes it try EGL and OSMesa.
                warnings.filterwarnings("error", category=UserWarning, module="glfw")
                return importlib.import_module(name)
        except (AttributeError, ImportError, OSError, RuntimeError):  # as the GL libraries please
            os.environ["MUJOCO_GL"] = "off"
            return importlib.import_module(name)  # another cause comes up again


@contextmanager
def choices_kept() -> Iterator[None]:
    """What the block sets is forgotten: processes that are started later choose for themselves."""
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

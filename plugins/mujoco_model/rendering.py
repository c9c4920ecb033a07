"""Frames of an arm, for the simulators on MuJoCo's engine.

MuJoCo's own `Renderer` is not used, for three reasons. It opens a context of the library that MUJOCO_GL named while
MuJoCo was imported. It aborts the interpreter if that library opens none. When it is closed, it frees what belongs to
another renderer.
"""

import atexit
import copy
import importlib
import os
import sys
import warnings
import weakref
from contextlib import suppress
from typing import Any

import numpy as np
from numpy.typing import NDArray

from harness import Float
from harness.errors import UsageError, one_line
from harness.robot import Robot
from harness.simulator import Camera

from .engine import choices_kept, mujoco
from .model import TARGET

WITHOUT_DISPLAY = ("egl", "osmesa")
"""Values of MUJOCO_GL with which Linux renders without a display."""
MAX_GEOMS = 10_000
"""The largest number of shapes in a frame, as in MuJoCo's own renderer."""

_failures: list[str] = []
"""Why MuJoCo could not draw into a context. It may abort the interpreter if it is asked a second time."""


class Renderer:
    """Draws frames of an arm in a world of its own, apart from the simulated ones.

    Args:
        model: The model of the arm and a target, from `build_model`; it is not changed.
        robot: The arm.
    """

    def __init__(self, model: mujoco.MjModel, robot: Robot) -> None:
        self._model, self._robot = model, robot
        self._canvas: Canvas | None = None

    def frame(self, qpos: Float, target: Float, width: int, height: int) -> NDArray[np.uint8]:
        """The arm at `qpos`, (dof,), and a marker at `target`, (3,), [m]; RGB, (height, width, 3).

        Raises:
            UsageError: This machine cannot render; says what to install.
        """
        try:
            if self._canvas is None or self._canvas.size != (width, height):
                self.close()
                self._canvas = Canvas(self._model, Camera.of(self._robot, width, height))
            return self._canvas.draw(qpos, target)
        except Exception as error:  # the GL libraries raise errors of many kinds
            raise _refusal(error) from error

    def close(self) -> None:
        """Release the renderer; a second call does nothing."""
        if self._canvas is not None:
            self._canvas.close()
            self._canvas = None


class Canvas:
    """Draws frames of one size."""

    def __init__(self, model: mujoco.MjModel, camera: Camera) -> None:
        self.size = width, height = camera.width, camera.height
        self._model = copy.copy(model)
        self._model.vis.global_.offwidth, self._model.vis.global_.offheight = width, height
        self._model.vis.global_.fovy = camera.field_of_view
        self._model.geom(TARGET).size[0] = camera.marker
        self._data = mujoco.MjData(self._model)
        self._scene = mujoco.MjvScene(self._model, MAX_GEOMS)
        self._option, self._camera, self._area = (
            mujoco.MjvOption(),
            _of_mujoco(camera),
            mujoco.MjrRect(0, 0, width, height),
        )
        self._context = _open_context(width, height)
        self._drawing = _open_drawing(self._model)
        # `close`, the garbage collector or the end of the interpreter calls it, whichever comes first. At the end of
        # the interpreter it must run before the libraries clean up. `atexit` ensures that, `weakref` does not.
        self._release = weakref.finalize(self, _release, self._context, self._drawing)
        self._release.atexit = False
        atexit.register(self._release)

    def draw(self, qpos: Float, target: Float) -> NDArray[np.uint8]:
        data, (width, height) = self._data, self.size
        data.qpos[:], data.mocap_pos[0] = qpos, target
        mujoco.mj_forward(self._model, data)
        self._context.make_current()
        mujoco.mjv_updateScene(
            self._model, data, self._option, None, self._camera, mujoco.mjtCatBit.mjCAT_ALL, self._scene
        )
        mujoco.mjr_render(self._area, self._scene, self._drawing)
        pixels = np.empty((height, width, 3), np.uint8)
        mujoco.mjr_readPixels(pixels, None, self._area, self._drawing)
        return np.ascontiguousarray(pixels[::-1])  # OpenGL begins with the lowest row

    def close(self) -> None:
        """Release the context; a second call does nothing."""
        atexit.unregister(self._release)
        self._release()


def _release(context: Any, drawing: Any) -> None:
    with suppress(Exception):  # what cannot be freed any more need not be
        context.make_current()  # MuJoCo frees in whichever context is current
        drawing.free()
        context.free()


def _open_context(width: int, height: int) -> Any:
    """A GL context, current in this thread."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # GLFW warns of what it cannot do, and goes on
        kind = _context_class()
        context = kind(width, height)
        context.make_current()
        if kind.__module__ == "mujoco.glfw" and not importlib.import_module("glfw").get_current_context():
            raise RuntimeError("GLFW opens no window")
    return context


def _context_class() -> Any:
    """The context class of the library that MUJOCO_GL names now; EGL if it names none and there is no display.

    Each canvas asks for it, not the import of MuJoCo. So no environment variable has to be set before the import, a
    training loads no GL library that it does not need, and it does not matter who imported MuJoCo first.
    """
    chosen = os.environ.get("MUJOCO_GL", "").strip().lower() or ("egl" if _lacks_display() else "")
    if sys.platform == "linux" and chosen in WITHOUT_DISPLAY:
        with choices_kept():
            return importlib.import_module(f"mujoco.{chosen}").GLContext
    if not hasattr(mujoco, "GLContext"):
        raise RuntimeError("MuJoCo has loaded no library that renders")
    return mujoco.GLContext


def _refusal(error: Exception) -> UsageError:
    given = os.environ.get("MUJOCO_GL")
    choice = f"with MUJOCO_GL={given}" if given else "without MUJOCO_GL"
    advice = "install libegl1 and set MUJOCO_GL=egl, or libosmesa6 and MUJOCO_GL=osmesa"
    if sys.platform != "linux":
        advice = "leave MUJOCO_GL unset"
    return UsageError(f"MuJoCo cannot render here {choice} ({one_line(error)}): {advice}")


def _lacks_display() -> bool:
    """Whether this is a Linux without a screen; macOS and Windows render by what they have."""
    return sys.platform == "linux" and not (os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"))


def _open_drawing(model: mujoco.MjModel) -> Any:
    """MuJoCo's own resources for drawing, in the current context."""
    if _failures:
        raise mujoco.FatalError(_failures[0])
    try:
        drawing = mujoco.MjrContext(model, mujoco.mjtFontScale.mjFONTSCALE_150)
    except mujoco.FatalError as error:
        _failures.append(str(error))
        raise
    mujoco.mjr_setBuffer(mujoco.mjtFramebuffer.mjFB_OFFSCREEN, drawing)
    return drawing


def _of_mujoco(camera: Camera) -> mujoco.MjvCamera:
    same = mujoco.MjvCamera()
    same.lookat[:] = camera.centre
    same.distance, same.azimuth, same.elevation = camera.distance, camera.azimuth, camera.elevation
    return same

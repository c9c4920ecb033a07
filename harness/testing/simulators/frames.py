"""Frames: RGB, of the size asked for, with the target in them; or a reason why there are none."""

import numpy as np
from numpy.typing import NDArray

from harness.arrays import Float
from harness.errors import UsageError
from harness.robot import Robot
from harness.simulator import Simulation, Simulator
from harness.testing.simulators.simulations import drive_out_and_back, opened, same, start_at_home
from harness.testing.violations import check, require

TARGET = np.array([0.6, 0.2, 0.5])
"""The target of the frames, [m]."""


@check("sim-render")
def render_gives_a_frame_or_says_why_not(simulator: Simulator, robot: Robot) -> None:
    """`render` gives RGB frames, each of the size asked for, or raises UsageError; the state stays as it was."""
    with opened(simulator, robot) as simulation:
        before = drive_out_and_back(simulation, robot)[-1]
        for width, height in ((64, 48), (80, 60)):
            frame = _frame(simulation, TARGET, width, height)
            if frame is None:
                return
            size = f"a frame of {width} x {height}"
            require(frame.shape == (height, width, 3), f"{size} has shape {frame.shape}, not {(height, width, 3)}")
            require(frame.dtype == np.uint8, f"{size} is {frame.dtype}, not uint8")
        require(same([simulation.read()], [before]), "rendering changed the state")


@check("sim-render-target")
def frames_show_the_target(simulator: Simulator, robot: Robot) -> None:
    """If `render` gives frames, a target at another place gives another frame."""
    with opened(simulator, robot) as simulation:
        start_at_home(simulation, robot)
        first, second = (_frame(simulation, TARGET + offset, 320, 240) for offset in (0.0, 0.2))
        if first is not None and second is not None:
            require(not np.array_equal(first, second), "the frame is the same wherever the target is")


@check("sim-render-tried", "warning")
def frames_were_tried(simulator: Simulator, robot: Robot) -> None:
    """`render` gives a frame on this machine. If it does not, drawing could not be tried here."""
    with opened(simulator, robot) as simulation:
        start_at_home(simulation, robot)
        try:
            simulation.render(0, TARGET, 64, 48)
        except UsageError as error:
            raise AssertionError(f"rendering was not tried: {error}") from error


def _frame(simulation: Simulation, target: Float, width: int, height: int) -> NDArray[np.uint8] | None:
    """A frame of env 1, the caller's own; None where the simulator says that it cannot."""
    try:
        return np.array(simulation.render(1, target, width, height))
    except UsageError:
        return None

"""Frames for simulators that draw none of their own."""

import numpy as np

from harness.simulator import StillFrames


def test_a_frame_has_its_size_and_shows_the_target(robot):
    """RGB of bytes; another target gives another frame, and closing takes nothing away."""
    frames, tip = StillFrames(robot), robot.end_effector(robot.home)
    one = frames.frame(robot.home, tip / 2, 80, 60)
    frames.close()
    assert (one.shape, one.dtype) == ((60, 80, 3), np.uint8)
    assert (frames.frame(robot.home, tip / 3, 80, 60) != one).any()

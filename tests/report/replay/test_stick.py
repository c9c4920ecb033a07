"""An arm as a line, where no script draws it."""

import re

from numpy.testing import assert_allclose

from harness.report.replay.section import draw_sticks, joints_of
from harness.results.replay import shows_of
from harness.robot.kinematics import end_effector_position
from harness.scene.picture import chain_of


def test_the_line_ends_where_kinematics_says(recorded):
    """At the start and the end of an episode."""
    (show,) = shows_of(recorded)
    for row in (0, -1):
        side = show.sides[1]
        qpos = side.episodes[0].qpos[row]
        expected = end_effector_position(chain_of(side.scene), qpos)
        assert_allclose(joints_of(side.scene, qpos)[-1], expected, atol=1e-9)


def test_each_side_is_drawn_in_one_scale(recorded):
    """A line through the foot, all joints and the end effector; a ring at the target."""
    (show,) = shows_of(recorded)
    drawn = draw_sticks(show.sides, 0)
    assert len({re.search('viewBox="[^"]+"', it)[0] for it in drawn}) == 1
    for side, it in zip(show.sides, drawn, strict=True):
        assert len(re.search('points="([^"]+)"', it)[1].split()) == len(side.scene.joints) + 2
        assert it.count("<circle") == 1

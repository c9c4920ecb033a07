"""Which links may touch one another."""

import numpy as np
import pytest

from harness_plugins.arms.self_collision import pair, pairs_apart, partners
from tests.registered import FD100 as ROBOT


def test_neighbours_are_left_out():
    """Of three joints' four groups three pairs stay."""
    assert pairs_apart(3) == {(0, 2), (0, 3), (1, 3)}


def test_pairs_are_found_from_both_sides():
    """Whichever group is asked for."""
    assert pair(3, 1) == pair(1, 3) == (1, 3)
    assert (partners(3, pairs_apart(3)), partners(0, pairs_apart(3))) == ({0, 1}, {2, 3})


def test_base_has_the_shapes_that_no_joint_moves():
    """The FD100's pedestal, foot plate and connector box, where they stand in the world."""
    shapes = ROBOT.base_shapes
    assert [shape.kind for shape in shapes] == ["cylinder", "box", "box"]
    assert shapes[1].T_link_shape[:3, 3] == pytest.approx([0.0, 0.0, 0.015])
    moved = sum(len(group) for group in ROBOT.joint_shapes)
    assert len(shapes) + moved == sum(len(group) for group in ROBOT.link_shapes.values())
    assert np.shape(shapes[0].T_link_shape) == (4, 4)

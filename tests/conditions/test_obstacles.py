"""What obstacles are, as text, as numbers and as a learner sees them."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from harness.conditions.obstacles import distance_from, parse_obstacles, seen_from, there


def test_text_becomes_spheres_and_boxes():
    """Four numbers are a sphere, six a box whose edges become half edges."""
    both = parse_obstacles("0.5x-0.1x0.6x0.08+0.6x0.3x0.2x0.1x0.2x0.4")
    assert_allclose(both, [[0.5, -0.1, 0.6, 0, 0, 0, 0.08], [0.6, 0.3, 0.2, 0.05, 0.1, 0.2, 0]])
    assert parse_obstacles("").shape == (0, 7)


def test_other_text_is_refused(subtests):
    """The message shows the obstacle that is none."""
    for text in ["1x2x3", "1x2x3x0", "axbxcx1", "1x2x3x1x1x-1", "1x2x3xnan", "1x2x3x1+"[:-1] + "x1"]:
        with subtests.test(text=text), pytest.raises(ValueError, match="neither a sphere"):
            parse_obstacles(text)


def test_distance_from_surfaces():
    """Beside a sphere, inside it, beside a box and at its corner."""
    sphere, box = np.array([0.0, 0, 0, 0, 0, 0, 0.5]), np.array([0.0, 0, 0, 1, 1, 1, 0])
    points = np.array([[2.0, 0, 0], [0.0, 0, 0], [4.0, 5, 1]])
    assert_allclose(distance_from(points, sphere), [1.5, -0.5, np.sqrt(42) - 0.5])
    assert_allclose(distance_from(points, box), [1.0, 0.0, 5.0])


def test_the_nearest_are_seen_first_and_from_the_end_effector():
    """As many as asked for; zeros where there are fewer."""
    far, near, none = [3.0, 0, 0, 0, 0, 0, 0.1], [1.0, 0, 0, 0.2, 0.2, 0.2, 0], [0.0] * 7
    seen = seen_from(np.array([[0.5, 0, 0]]), np.array([[far, none, near]]), 4)
    assert_allclose(seen[0, 0], [0.5, 0, 0, 0.2, 0.2, 0.2, 0])
    assert_allclose(seen[0, 1], [2.5, 0, 0, 0, 0, 0, 0.1])
    assert not there(seen[0, 2:]).any()
    assert seen_from(np.array([[0.5, 0, 0]]), np.array([[far, none, near]]), 1).shape == (1, 1, 7)

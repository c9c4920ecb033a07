"""What things have in common."""

from harness.report.rows.comparison import tell_apart


def test_same_parts_are_said_once():
    """The others tell each apart, in their order."""
    apart = tell_apart([("mujoco", "sac", "fd100"), ("pybullet", "sac", "fd100")])
    assert (apart.shared, apart.names) == ("sac · fd100", ["mujoco", "pybullet"])


def test_single_thing_has_nothing_to_be_told_apart_from():
    """Unless a part is kept for its name."""
    assert tell_apart([("mujoco", "sac")]) == ("mujoco · sac", [""])
    assert tell_apart([("mujoco", "sac")], keep=1) == ("mujoco", ["sac"])


def test_nothing_has_nothing_in_common():
    """And no names."""
    assert tell_apart([]) == ("", [])

"""Steps: named fields, and a refusal by name of what is not there."""

import numpy as np
import pytest
from numpy.testing import assert_array_equal

from harness.errors import UsageError
from harness.reward import Sample
from harness.reward.steps import ARM, ARM_BEFORE, BEFORE, MissingField
from harness.reward.terms import made_up


def test_a_step_of_an_arm_has_what_the_table_says():
    """Each field, in the table's order, and of what was before those that are marked."""
    steps = made_up(6, 6)
    assert steps._fields == (*(field.name for field in ARM), BEFORE)
    assert steps.before._fields == ARM_BEFORE


@pytest.mark.parametrize(
    ("field", "nearest"),
    [("joint_speed", "qvel"), ("distanse", "distance"), ("actions", "action"), ("ee_pos", "end_effector")],
)
def test_a_field_that_is_not_there_is_refused_with_the_nearest(field, nearest):
    """Never None: also what others call it is known."""
    with pytest.raises(MissingField, match=rf"has no '{field}'\. It has: begin_distance, .*Did you mean '{nearest}'\?"):
        getattr(made_up(6, 6), field)


def test_a_missing_field_is_a_users_error_and_an_attribute_that_is_not_there():
    """So that ``hasattr`` and ``getattr`` with a default go on working."""
    with pytest.raises(UsageError):
        made_up(6, 6).speedy  # noqa: B018
    assert not hasattr(made_up(6, 6), "speedy")
    assert getattr(made_up(6, 6).before, "speedy", 3) == 3


def test_distances_alone_refuse_the_rest_too():
    """Six distances that somebody made by hand have no qpos."""
    with pytest.raises(MissingField, match="has no 'qpos'"):
        Sample(*np.ones((6, 2))).qpos  # noqa: B018


def test_who_unpacks_a_step_gets_the_distances():
    """As in version 0.2, whose rewards knew no more."""
    steps = made_up(6, 6)
    begin, best, previous, distance, delta, step = steps
    assert [begin, best, previous, distance, delta, step] == [getattr(steps, name) for name in Sample._fields]
    assert Sample(*steps).distance is steps.distance


def test_a_replaced_field_leaves_the_others():
    """Also the ones beside the distances."""
    steps = made_up(6, 6)
    other = steps._replace(distance=steps.distance + 1.0)
    assert other.qvel is steps.qvel
    assert_array_equal(other.distance, steps.distance + 1.0)

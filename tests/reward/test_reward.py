import copy
import pickle

import numpy as np
import pytest
from numpy.testing import assert_array_equal

from harness.reward import Sample, pay
from harness.reward.forms import is_plain_function, reward_class
from harness.reward.reward import put, replace_where, take
from harness.reward.steps import map_steps, rows_of, step_between
from harness.reward.terms import made_up, needs_of

CARRY = (np.array([1.0, 2.0, 3.0]), (np.arange(6).reshape(3, 2), ()))


def test_episodes_of_the_mask_are_replaced():
    """Every array of a nested carry takes the masked rows from the fresh one."""
    fresh = (np.zeros(3), (np.zeros((3, 2), int), ()))
    first, (second, empty) = replace_where(np.array([True, False, True]), fresh, CARRY)
    assert_array_equal(first, [0, 2, 0])
    assert_array_equal(second, [[0, 0], [2, 3], [0, 0]])
    assert empty == ()


def test_what_is_taken_is_put_back():
    """Putting back what was taken changes nothing."""
    index = np.array([True, False, True])
    first, (second, _) = put(CARRY, index, take(CARRY, index))
    assert_array_equal(first, CARRY[0])
    assert_array_equal(second, CARRY[1][0])


def test_putting_leaves_the_carry_given_alone():
    """Rewards are pure, and so is the handling of what they remember."""
    carry = np.array([1.0, 2.0])
    assert put(carry, np.array([0]), np.array([9.0])).tolist() == [9.0, 2.0]
    assert carry.tolist() == [1.0, 2.0]


def test_a_finer_type_is_kept():
    """A carry that starts as whole numbers may go on as fractions."""
    assert put(np.array([1, 2]), np.array([0]), np.array([0.5])).tolist() == [0.5, 2.0]


def test_copied_steps_have_every_field():
    """Who unpacks a step gets six distances; a copy is whole all the same."""
    steps = made_up(6, 6)
    for other in (copy.copy(steps), copy.deepcopy(steps)):
        assert other._fields == steps._fields
        assert (other.before.action == steps.before.action).all()
    assert other.qpos is not steps.qpos
    assert pickle.loads(pickle.dumps(Sample(*range(6)))) == Sample(*range(6))


def test_steps_are_mapped_with_what_was_before():
    """Arrays of both; rows are a case of it."""
    steps = made_up(6, 6)
    assert (map_steps(lambda array: 2 * array, steps).before.qpos == 2 * steps.before.qpos).all()
    assert_array_equal(rows_of(steps, slice(1, 2)).before.action, steps.before.action[1:])


def test_a_step_goes_from_one_state_to_another():
    """Its previous distance is the one before; gains count from the best."""
    states = [{"distance": np.array([0.4]), "action": np.array([[0.0]])}, {"distance": np.array([0.3])}]
    step = step_between(states[0], {**states[1], "action": np.array([[1.0]])}, *map(np.array, ([0.5], [0.35], [2.0])))
    assert (step.previous_distance, step.before.action[0, 0], step.action[0, 0]) == (0.4, 0.0, 1.0)
    assert step.delta_distance == pytest.approx(-0.05)


def test_who_unpacks_a_step_reads_distances():
    """And not what else a step has: an audit may ask such a reward about distances alone."""

    def unpacked(step):
        begin, _, _, distance, *_ = step
        return begin - distance

    assert needs_of(reward_class(unpacked)()).fields == tuple(sorted(Sample._fields))


def test_made_up_steps_cannot_be_spoilt():
    """They are kept for the next reward."""
    with pytest.raises(ValueError, match="read-only"):
        made_up(6, 6).before.action[0] = 1.0


def test_a_plain_function_is_known_as_one():
    """A dataclass is none."""

    def plain(step):
        return -step.distance

    assert is_plain_function(reward_class(plain)())
    assert not is_plain_function(object())


def test_a_total_of_another_library_is_taken_as_it_is():
    """Its arrays may have no numbers yet, as while JAX compiles; numpy's are compared."""

    class Opaque:
        shape = (2,)

        def __array__(self, *args, **kwargs):
            raise TypeError("no numbers here")

        def __array_namespace__(self, api_version=None):
            raise NotImplementedError

        def __radd__(self, other):
            return self

    class Fixed:
        def __call__(self, carry, steps):
            return carry, (Opaque(), {"reach": Opaque()})

    assert isinstance(pay(Fixed(), (), None)[1].terms["reach"], Opaque)

import numpy as np

from harness.reward import put, replace_where, take

CARRY = (np.array([1.0, 2.0, 3.0]), (np.arange(6).reshape(3, 2), ()))


def test_episodes_of_the_mask_are_replaced():
    """Every array of a nested carry takes the masked rows from the fresh one."""
    fresh = (np.zeros(3), (np.zeros((3, 2), int), ()))
    first, (second, empty) = replace_where(np.array([True, False, True]), fresh, CARRY)
    np.testing.assert_array_equal(first, [0, 2, 0])
    np.testing.assert_array_equal(second, [[0, 0], [2, 3], [0, 0]])
    assert empty == ()


def test_what_is_taken_is_put_back():
    """Putting back what was taken changes nothing."""
    index = np.array([True, False, True])
    first, (second, _) = put(CARRY, index, take(CARRY, index))
    np.testing.assert_array_equal(first, CARRY[0])
    np.testing.assert_array_equal(second, CARRY[1][0])


def test_putting_leaves_the_carry_given_alone():
    """Rewards are pure, and so is the handling of what they remember."""
    carry = np.array([1.0, 2.0])
    assert put(carry, np.array([0]), np.array([9.0])).tolist() == [9.0, 2.0]
    assert carry.tolist() == [1.0, 2.0]


def test_a_finer_type_is_kept():
    """A carry that starts as whole numbers may go on as fractions."""
    assert put(np.array([1, 2]), np.array([0]), np.array([0.5])).tolist() == [0.5, 2.0]

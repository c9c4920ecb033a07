"""Dry friction in joints: what Coulomb's law asks of the speeds after it."""

import numpy as np
import pytest
from hypothesis import given, strategies as st
from numpy.random import default_rng
from numpy.testing import assert_allclose, assert_array_equal

from harness_plugins.arms.dry_friction import DryFriction


@given(seed=st.integers(0, 2**32 - 1), dof=st.integers(1, 8))
def test_each_joint_stands_still_or_is_slowed_with_all_there_is(seed, dof):
    """Speeds follow from impulses within the limits; a joint that still moves has the whole impulse against it."""
    rng = default_rng(seed)
    root = rng.normal(size=(dof, dof))
    mobility, most = root @ root.T / dof + np.eye(dof), rng.uniform(0.0, 2.0, dof) * rng.integers(0, 2, dof)
    before, friction = rng.normal(size=dof), DryFriction(most)
    after, impulses = friction.slow(before, mobility), friction.impulses
    assert_allclose(after, before - mobility @ impulses, atol=1e-9)
    assert (np.abs(impulses) <= most).all()
    moving = np.abs(after) > 1e-4
    assert_array_equal(impulses[moving], (np.sign(after) * most)[moving])


def test_one_joint_by_hand():
    """An impulse of 0.5 takes 1 from a speed of 3 where the mobility is 2, and holds a speed of 0.9 still."""
    for before, after in ((3.0, 2.0), (-3.0, -2.0), (0.9, 0.0)):
        assert DryFriction(np.array([0.5])).slow(np.array([before]), np.array([[2.0]])) == pytest.approx([after])


def test_what_was_found_before_changes_the_search_alone():
    """The next search begins with the impulses of the last one, and ends where a new one does."""
    mobility, used = np.array([[2.0, 0.9], [0.9, 1.0]]), DryFriction(np.array([0.3, 0.4]))
    used.slow(np.array([-5.0, 4.0]), mobility)
    speeds = np.array([0.5, 0.6])
    new = DryFriction(np.array([0.3, 0.4])).slow(speeds, mobility)
    assert_allclose(used.slow(speeds, mobility), new, atol=1e-9)
    used.forget()
    assert_array_equal(used.slow(speeds, mobility), new)

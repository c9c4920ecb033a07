"""What terms paid, by episode."""

import json

import numpy as np

from harness.results.by_term import ByTerm, by_term, part_of

EPISODES = [np.array([3, 4]), np.array([0, 1, 2]), np.array([5])]  # not in the order in which they ended


def test_a_term_is_summed_over_each_episode():
    """Start and end are the first and the last that ended; the whole is the mean over all."""
    found = by_term({"a": np.array([1.0, 1.0, 1.0, 2.0, 2.0, 8.0])}, EPISODES, 6).terms["a"]
    assert (found.start, found.end, found.whole) == (3.0, 8.0, 5.0)


def test_a_tenth_of_the_episodes_is_a_part():
    """At least one."""
    assert [part_of(count) for count in (0, 1, 9, 20, 26, 1000)] == [1, 1, 1, 2, 3, 100]


def test_a_step_of_an_episode_that_did_not_end_is_pay_too():
    """A term that paid once has paid, though no episode says so."""
    values = np.zeros(8)
    values[7] = -1e-300
    found = by_term({"late": values, "never": np.zeros(8), "minus": -np.zeros(8)}, EPISODES, 8)
    assert [means.pays for means in found.terms.values()] == [True, False, False]


def test_without_an_episode_there_is_no_mean():
    """But what there is of steps is counted; a start row is no step."""
    found = by_term({"a": np.zeros(3)}, [], 2)
    assert (found.terms["a"].whole, found.steps) == (None, 2)


def test_what_is_kept_is_what_was_told():
    """After a way through JSON."""
    found = by_term({"a": np.arange(6.0)}, EPISODES, 6)
    assert ByTerm.again(*json.loads(json.dumps(found))) == found

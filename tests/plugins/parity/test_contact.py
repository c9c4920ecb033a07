"""Ground contact of two simulators, by hand."""

import numpy as np
import pytest

from harness_plugins.parity.difference import compare_contacts, first_contacts

ROWS, GRACE = 20, 5


def touching(*firsts):
    """Contact from a row on, for each episode; never where None."""
    rows = np.arange(ROWS)[:, None]
    return rows >= np.array([ROWS if first is None else first for first in firsts])


def test_first_contacts_by_hand():
    """The first row, or the number of rows."""
    assert first_contacts(touching(0, 7, None)).tolist() == [0, 7, ROWS]


def test_the_same_contacts_do_not_disagree():
    """No share, no delay, no note."""
    contact = compare_contacts(touching(4, 9), touching(4, 9), 0.1)
    assert (contact.disagreement, contact.mean_delay_s, contact.max_delay_s) == (0.0, 0.0, 0.0)
    assert (contact.both, contact.note) == (2, "")


def test_a_late_contact_by_hand():
    """Two periods late in one of two dives: 2 of the samples up to `GRACE` after the first contacts."""
    contact = compare_contacts(touching(4, 9), touching(6, 9), 0.1)
    assert contact.disagreement == pytest.approx(2 / ((4 + 1 + GRACE) + (9 + 1 + GRACE)))
    assert contact.mean_delay_s == pytest.approx(0.1)
    assert contact.max_delay_s == pytest.approx(0.2)


def test_an_early_contact_has_a_negative_delay():
    """The other way round: same share, opposite delay."""
    late, early = (compare_contacts(*pair, 0.1) for pair in ([touching(4), touching(6)], [touching(6), touching(4)]))
    assert early.disagreement == late.disagreement
    assert early.mean_delay_s == pytest.approx(-0.2)
    assert early.max_delay_s == pytest.approx(0.2)


def test_what_comes_after_does_not_count():
    """Bouncing long after the first contact is no disagreement."""
    bouncing = touching(2)
    bouncing[2 + GRACE + 1 :] = False
    assert compare_contacts(touching(2), bouncing, 0.1).disagreement == 0.0


def test_one_that_never_touches_is_told():
    """Its dive counts as disagreement, and not for the delay."""
    contact = compare_contacts(touching(4), touching(None), 0.1)
    assert contact.disagreement == pytest.approx((1 + GRACE) / (4 + 1 + GRACE))
    assert (contact.only_a, contact.mean_delay_s, contact.max_delay_s) == (1, None, None)
    assert contact.note == "of 1 dives, 1 in the first alone touch the ground"


def test_a_dive_that_touches_nothing_is_told():
    """In neither of the two: no disagreement, but no evidence either."""
    contact = compare_contacts(touching(None, 3), touching(None, 3), 0.1)
    assert (contact.disagreement, contact.neither, contact.both) == (0.0, 1, 1)
    assert "1 in neither" in contact.note

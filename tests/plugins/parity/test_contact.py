"""Ground contact of two simulators, by hand."""

import numpy as np
import pytest

from harness_plugins.parity.difference import compare_contacts

ROWS, GRACE = 20, 5


def touching(*firsts):
    """Contact from a row on, for each episode; never where None."""
    return np.arange(ROWS)[:, None] >= np.array([ROWS if first is None else first for first in firsts])


CONTACTS = {
    "the same contacts do not disagree": ((4, 9), (4, 9), 0.0, (0.0, 0.0), {"both": 2}, ""),
    "two periods late in one of two dives: 2 of the samples up to `GRACE` after the first contacts": (
        *((4, 9), (6, 9), 2 / ((4 + 1 + GRACE) + (9 + 1 + GRACE)), (0.1, 0.2), {"both": 2}, ""),
    ),
    "an early contact: the same share, the opposite delay": ((6,), (4,), 0.2, (-0.2, 0.2), {"both": 1}, ""),
    "a late contact": ((4,), (6,), 0.2, (0.2, 0.2), {"both": 1}, ""),
    "one that never touches disagrees, and has no delay": (
        *((4,), (None,), (1 + GRACE) / (4 + 1 + GRACE), (None, None), {"only_a": 1}),
        "of 1 dives, 1 in the first alone touch the ground",
    ),
    "a dive that touches nothing is no disagreement, but no evidence either": (
        *((None, 3), (None, 3), 0.0, (0.0, 0.0), {"both": 1, "neither": 1}, "1 in neither"),
    ),
}


@pytest.mark.parametrize(("one", "other", "share", "delays", "counts", "note"), CONTACTS.values(), ids=CONTACTS)
def test_contacts_by_hand(one, other, share, delays, counts, note):
    """The share in which they disagree, the mean and the largest delay, how many dives touch in which."""
    contact = compare_contacts(touching(*one), touching(*other), 0.1)
    assert contact.disagreement == pytest.approx(share)
    found = (contact.mean_delay_s, contact.max_delay_s)
    assert found == delays if None in delays else found == pytest.approx(delays)
    dives = ("both", "only_a", "only_b", "neither")
    assert {name: count for name in dives if (count := getattr(contact, name))} == counts
    assert note in contact.note
    assert bool(note) == bool(contact.note)


def test_what_comes_after_does_not_count():
    """Bouncing long after the first contact is no disagreement."""
    bouncing = touching(2)
    bouncing[2 + GRACE + 1 :] = False
    assert compare_contacts(touching(2), bouncing, 0.1).disagreement == 0.0

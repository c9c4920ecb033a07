"""What envs were told, in order, and whether it was answered alike."""

import numpy as np
import pytest

from harness.errors import SchemaError
from harness.experiment.environments.world import FIRST_ROOM, StepLog, actions_of

ANSWER = np.zeros((2, 3), np.float32)


def _log(told, answer=ANSWER):
    """A log of actions, and of None for a reset."""
    log = StepLog()
    log.note_reset(is_plain=False)
    for actions in told:
        if actions is None:
            log.note_reset(is_plain=True)
        else:
            log.note_actions(actions)
        log.note_answers(answer)
    return log


def test_it_tells_what_was_told_in_order():
    """Resets between the actions, several in a row and the last one too; the first, which has a seed, is left out."""
    one, two = np.array([[1.0], [2.0]]), np.array([[3.0], [4.0]])
    told = [None, None, one, None, two, None]
    again = list(actions_of(_log(told).state()))
    assert [None if it is None else it.tolist() for it in again] == [None if it is None else it.tolist() for it in told]


def test_it_grows():
    """Every action is kept, of whatever type."""
    rows = [np.array([step % 5, 1]) for step in range(2 * FIRST_ROOM + 3)]
    again = list(actions_of(_log(rows).state()))
    assert np.array_equal(again, rows)
    assert again[0].dtype == rows[0].dtype


@pytest.mark.parametrize("other", [_log([None], ANSWER + 1), _log([None, None])], ids=["other numbers", "more of them"])
def test_other_answers_are_noticed(other):
    """A number, or one more answer; the same ones are the same."""
    _log([None]).require_same(_log([None]).state())
    with pytest.raises(SchemaError, match="did something else"):
        other.require_same(_log([None]).state())


@pytest.mark.parametrize(
    ("resets", "is_complete"), [([False], True), ([False, True], True), ([False, False], False), ([True], False)]
)
def test_a_reset_that_cannot_be_repeated_is_noticed(resets, is_complete):
    """The first has to have a seed, and no other one may."""
    log = StepLog()
    for is_plain in resets:
        log.note_reset(is_plain)
    assert log.is_complete == is_complete

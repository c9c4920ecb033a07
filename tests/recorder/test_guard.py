"""How functions that look on are asked."""

import random
import signal
import time

import numpy as np
import pytest

from harness.recorder import guard as room
from harness.recorder.guard import Guard


@pytest.fixture
def quick(monkeypatch):
    """A call may take a tenth of a second."""
    monkeypatch.setattr(room, "LONGEST_CALL", 0.1)


def _step(guard, action):
    seen = guard.seal(np.ones(2))
    return seen, guard.seal(action), seen, guard.seal({"x": 1.0})


def test_function_that_writes_is_told_what_to_write_instead():
    """The others and the learner have their action; the message names what it writes into."""

    def halves(observation, action, next_observation, info):
        action /= 2
        return 0.0

    guard, action = Guard(), np.array([4.0])
    step = _step(guard, action)
    first, second = guard.ask([halves, lambda s, a, n, i: float(a[0])], [step, step])
    assert (second, action.tolist(), action.flags.writeable) == (4.0, [4.0], True)
    told = guard.reason(halves, step, first.error)
    assert told.startswith("it writes into its action, which others read too: write `action / 2` for `action /= 2`")


def test_other_errors_stay_what_they_are():
    """Also those of the same types."""
    guard = Guard()

    def fails(*step):
        raise ValueError("read-only")

    assert guard.reason(fails, _step(guard, np.ones(1)), ValueError("read-only")) == "ValueError: read-only"


def test_draws_are_put_back_unless_they_pay():
    """And each is named by its place."""
    guard = Guard()
    step = _step(guard, np.ones(1))
    random.seed(1)
    drawn = [random.random() for _ in range(2)]
    random.seed(1)
    answers = guard.ask([lambda *_: random.random()] * 2, [step] * 2)
    assert (answers, guard.drew) == ([drawn[0]] * 2, {0: "random", 1: "random"})
    guard.ask([lambda *_: random.random()] * 2, [step] * 2, pays=(0,))
    assert random.random() == drawn[1]


@pytest.mark.usefixtures("quick")
@pytest.mark.parametrize("how", ["loops", "sleeps", "catches"])
def test_function_that_never_returns_is_ended(how):
    """One that computes, one that waits, and one that goes on after every exception."""

    def stuck(*_):
        while True:
            try:
                time.sleep(60) if how == "sleeps" else None
            except Exception:
                if how != "catches":
                    raise

    guard = Guard()
    step = _step(guard, np.ones(1))
    with pytest.raises(TimeoutError, match=r"it has not returned for 0\.1 s"):
        guard.answer(stuck, step)
    assert guard.answer(lambda *_: 1.0, step) == 1.0


@pytest.mark.usefixtures("quick")
def test_time_counts_for_each_function():
    """Not for all of a step together."""
    guard = Guard()
    step = _step(guard, np.ones(1))
    answers = guard.ask([lambda *_: time.sleep(0.06) or 1.0] * 3, [step] * 3)
    assert answers == [1.0] * 3


@pytest.mark.usefixtures("quick")
def test_alarm_of_somebody_else_is_left_to_him():
    """Its handler, and the time that is left."""
    heard = []
    before = signal.signal(signal.SIGALRM, lambda number, frame: heard.append(number))
    try:
        guard = Guard()
        signal.setitimer(signal.ITIMER_REAL, 0.15)
        guard.ask([lambda *_: time.sleep(0.3)], [_step(guard, np.ones(1))])
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, before)
    assert heard == [signal.SIGALRM]

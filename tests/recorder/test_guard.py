"""How functions that look on are asked."""

import numpy as np

from harness.recorder.guard import Guard


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

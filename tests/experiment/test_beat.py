"""A word now and then."""

from types import SimpleNamespace

from harness.executor import Word
from harness.experiment.workers import order
from harness.experiment.workers.order import Beat


def test_a_word_is_said_once_in_a_while(monkeypatch):
    """Never before its time has come, and then once; it says how many steps are done."""
    now, told = [100.0], list[Word]()
    monkeypatch.setattr(order, "time", SimpleNamespace(monotonic=lambda: now[0]))
    say = Beat(told.append)
    for steps, later in ((1, 0.0), (2, 0.9), (3, 0.2), (4, 0.5), (5, 0.6)):
        now[0] += later
        say(steps)
    assert [word.steps for word in told] == [3, 5]

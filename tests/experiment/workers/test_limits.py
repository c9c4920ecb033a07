"""When a cell has to be ended."""

import pytest

from harness.executor import Limits
from harness.experiment.workers.workers import LONGEST_LOOK, Clock, Watchdog


class Times:
    """A clock that is set by hand."""

    def __init__(self) -> None:
        self.now = 100.0

    def __call__(self):
        """The time."""
        return self.now


@pytest.fixture
def times():
    """The time, set by hand."""
    return Times()


def _after(times, clock, seconds):
    for _ in range(seconds):
        times.now += 1.0
        clock.look()


def test_a_cell_without_progress_hangs(times):
    """From its last word on."""
    clock = Clock(times)
    watchdog = Watchdog(Limits(stall_after=10.0), clock)
    _after(times, clock, 8)
    watchdog.hear()
    _after(times, clock, 9)
    assert watchdog.complaint(lambda: 0) == ""
    _after(times, clock, 1)
    assert watchdog.complaint(lambda: 0) == "no progress for 10 s (--stall-after)"


def test_a_machine_that_slept_is_no_cell_that_hangs(times):
    """A long time between two looks counts little."""
    clock = Clock(times)
    watchdog = Watchdog(Limits(stall_after=10.0), clock)
    times.now += 3600.0
    assert clock.look() == LONGEST_LOOK
    assert watchdog.complaint(lambda: 0) == ""


def test_a_cell_may_get_on_and_still_take_too_long(times):
    """Progress is no excuse."""
    clock = Clock(times)
    watchdog = Watchdog(Limits(cell_time=5.0), clock)
    _after(times, clock, 5)
    watchdog.hear()
    assert watchdog.complaint(lambda: 0) == "it took longer than the 5 s that --cell-time allows"


def test_memory_is_asked_for_only_with_a_limit(times):
    """To look at a process takes time."""
    clock = Clock(times)
    assert Watchdog(Limits(), clock).complaint(lambda: pytest.fail("asked")) == ""
    complaint = Watchdog(Limits(cell_memory=2.0), clock).complaint(lambda: 3 * 2**30)
    assert complaint == "it used 3.00 GiB of memory, --cell-memory allows 2"

"""Watches a process that does an order: whether it makes progress, how long it takes, how much memory it uses."""

import time
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Final

from harness.executor import Limits

LOOK_EVERY: Final = 0.5
"""Seconds between two looks at the workers."""
LONGEST_LOOK: Final = 5.0
"""The most seconds that count between two looks, so that a machine that slept is not taken for a cell that hangs."""
GIB: Final = 2**30


class Clock:
    """Seconds that this process was awake and looked."""

    def __init__(self, now: Callable[[], float] = time.monotonic) -> None:
        self._now, self._last, self.seconds = now, now(), 0.0

    def look(self) -> float:
        """The time, with what has passed since the last look."""
        now = self._now()
        self.seconds += min(now - self._last, LONGEST_LOOK)
        self._last = now
        return self.seconds


@dataclass
class Watchdog:
    """The state of an order that is being done.

    Attributes:
        limits: What it may take.
        clock: Of the process that watches.
    """

    limits: Limits
    clock: Clock
    _started: float = field(init=False)
    _heard: float = field(init=False)

    def __post_init__(self) -> None:
        """Begin to watch the order."""
        self._started = self._heard = self.clock.seconds

    def hear(self) -> None:
        """Note that there is news of the order."""
        self._heard = self.clock.seconds

    def complaint(self, memory: Callable[[], int]) -> str:
        """Why the order has to be ended; empty if it may go on.

        Args:
            memory: Tells the bytes that its process has in memory; asked only if there is a limit.
        """
        now, limits = self.clock.seconds, self.limits
        if limits.stall_after and now - self._heard >= limits.stall_after:
            return f"no progress for {limits.stall_after:g} s (--stall-after)"
        if limits.cell_time and now - self._started >= limits.cell_time:
            return f"it took longer than the {limits.cell_time:g} s that --cell-time allows"
        if limits.cell_memory and (used := memory()) > limits.cell_memory * GIB:
            return f"it used {used / GIB:.2f} GiB of memory, --cell-memory allows {limits.cell_memory:g}"
        return ""

"""How much memory a plugin keeps: of Python's objects exactly, of everything roughly."""

import ctypes
import gc
import sys
import tracemalloc
from collections.abc import Callable

import psutil

from .contract import require

MOST_KEPT = 2.0
"""Bytes of Python's objects that may be kept of each step, on average: a list that grows by an entry keeps 8."""
SPARE = 4_000
"""Bytes that may be kept besides: libraries fill small caches at any time."""
PLAYS = 4
"""So often something has to be kept: libraries fill and empty caches of their own, a leak grows in every play."""
MOST_RESIDENT = 1_000.0
"""Bytes that a process may grow by with every step. Memory comes from the system in large pieces."""
MIB = 2**20


def require_nothing_kept(play: Callable[[], object], steps: int, noun: str) -> None:
    """Raise AssertionError if Python's objects, numpy's arrays among them, take more memory after `play` than before.

    Args:
        play: Takes `steps` steps. It is called twice, and more often if something was kept: in the first call caches
            may be filled.
        steps: How many.
        noun: What these are called.
    """
    traces = tracemalloc.is_tracing()
    if not traces:
        tracemalloc.start()
    # What there is already is looked at no more: the collections below take no time in which other threads of a large
    # process would give memory back, and hide what was kept.
    gc.collect()
    gc.freeze()
    try:
        play()
        allowed = MOST_KEPT * steps + SPARE
        for _ in range(PLAYS):
            before = _traced()
            play()
            kept = _traced() - before
            if kept <= allowed:
                break
    finally:
        gc.unfreeze()
        if not traces:
            tracemalloc.stop()
    require(
        kept <= allowed,
        f"{kept:,} bytes were kept of {steps:,} {noun}, {kept / steps:.0f} of each: memory grows without bound",
    )


def require_no_growth(before: int, steps: int, noun: str) -> None:
    """Raise AssertionError if this process has grown in `steps` steps since its `resident` memory was `before`."""
    grown = resident() - before
    require(
        grown <= MOST_RESIDENT * steps + MIB,
        f"the process grew by {grown / MIB:.1f} MiB in {steps:,} {noun}, {grown / steps:,.0f} bytes each: "
        "something is kept of every one",
    )


def resident() -> int:
    """Bytes of this process in memory, after what nobody needs is given back.

    glibc keeps freed memory, where what leaks would find room unseen: it is asked to give it back too.
    """
    gc.collect()
    trim = getattr(ctypes.CDLL(None), "malloc_trim", None) if sys.platform == "linux" else None
    if trim is not None:
        trim(0)
    return int(psutil.Process().memory_info().rss)


def _traced() -> int:
    gc.collect()
    return tracemalloc.get_traced_memory()[0]

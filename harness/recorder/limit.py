"""How long a function of a user may compute: a thread looks on, and ends a call where that leaves nothing half done.

That is where a loop jumps back and where a function begins. There CPython lets other threads run, and raises what they
left for it. It does so after each call of C too, which is never used: it looks like C that has not returned. An end is
like Ctrl-C, but imports, and what puts a state back, are left to run.
"""

import ctypes
import dis
import os
import sys
import time
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from threading import Thread, get_ident
from time import monotonic, sleep
from types import CodeType, FrameType
from typing import Any, Final

from harness.text import print_visible

LONGEST, LONGEST_TRIAL = 10.0, 60.0
"""What a call may compute, and one of the trial, which holds what compiles: CPU time of its thread, [s]."""
TOLD_AFTER, AGAIN_AFTER = 1.5, 0.1
"""When a call is told, by the clock on the wall; and when what goes on after its end is ended again. In limits."""
LOOK_EVERY, LOOK_CLOSELY_EVERY = 0.05, 0.005
"""How often the thread looks, and how often while a call is to be ended, [s]."""
TRIED = ((3, 11), (3, 12), (3, 13))
"""Versions of CPython on which calls were ended, also just at the limit. On others they are only told."""
ENDS: Final = (
    sys.platform == "linux"
    and sys.implementation.name == "cpython"
    and sys.version_info[:2] in TRIED
    and getattr(sys, "_is_gil_enabled", lambda: True)()
)
ENDS_AT = frozenset(
    code
    for name, code in dis.opmap.items()
    if name in ("RESUME", "JUMP_BACKWARD") or name.startswith("POP_JUMP_BACKWARD")
)
RUN_TO_THEIR_ENDS = frozenset({"<module>", "__enter__", "__exit__", "__del__"})

_raise = ctypes.PYFUNCTYPE(ctypes.c_int, ctypes.c_ulong, ctypes.py_object)(
    ("PyThreadState_SetAsyncExc", ctypes.pythonapi)
)
"""In a thread, at its next chance; with no exception: take back what has not been raised yet."""


class NoAnswer(BaseException):
    """A function has computed for too long. No ``except Exception`` of its own keeps it going."""


_NOTHING, _NO_ANSWER = ctypes.py_object(), ctypes.py_object(NoAnswer)


class _Run:
    """A call that has not returned.

    Attributes:
        undo: Arguments of `_raise` that take back what was raised in it; None while nothing was.
    """

    __slots__ = ("undo",)
    undo: Any


_running: dict[_Run, tuple[int, float]] = {}
"""The thread of each, and how long it may compute."""


def call(function: Callable[..., Any], given: Sequence[Any], longest: float) -> Any:
    """What a function says. `look_on` has to have been called.

    Raises:
        TimeoutError: It has computed for longer than `longest`, [s], and was ended.
    """
    run = _Run()
    run.undo = None
    _running[run] = get_ident(), longest
    answer = None
    try:
        answer = function(*given)
    except NoAnswer:
        if run.undo is None:  # it is that of a call around this one
            raise
    finally:
        # Up to the call of C nothing below lets another thread run, nor is an exception raised that was left: it is
        # taken back before.
        del _running[run]
        if run.undo is not None:
            _raise(*run.undo)
    if run.undo is not None:
        raise TimeoutError(f"it has not returned after {longest:g} s of computing")
    return answer


@dataclass
class _Watched:
    """What the thread knows of a call.

    Attributes:
        thread: Where it runs.
        longest: What it may compute, [s].
        clock: That of the thread's CPU time.
        computed: What that clock said when the call was first seen, [s].
        begun: When that was, [s].
        due: What it may have computed before it is ended, or ended again, [s].
    """

    thread: int
    longest: float
    clock: int
    computed: float
    begun: float
    due: float

    def look(self, run: _Run, told: set[str]) -> bool:
        """End the call or tell it, if it is time; returns whether it is still to be ended."""
        passed, computed = monotonic() - self.begun, _cpu_time(self.clock) - self.computed
        is_due = computed >= self.due
        if not is_due and passed < TOLD_AFTER * self.longest:
            return False
        frames = _frames(sys._current_frames().get(self.thread))
        if is_due and self._end(run, frames):
            self.due, is_due = computed + AGAIN_AFTER * self.longest, False
        elif passed >= TOLD_AFTER * self.longest and frames is not None:
            what = _named(frames)
            share = f", {computed:.1f} s of them computing" if ENDS else ""
            if what not in told:
                told.add(what)
                line = f"harness: {what} has not returned for {passed:.1f} s{share}: only a loop of Python is ended"
                with suppress(OSError, ValueError):  # nobody listens
                    print_visible(line, err=True)
        return is_due

    def _end(self, run: _Run, frames: Sequence[FrameType] | None) -> bool:
        """Raise `NoAnswer` in the call, if it stands where nothing is left half done; returns whether it did."""
        if not frames or any(_has_to_end(frame.f_code) for frame in frames):
            return False
        frame, thread = frames[0], ctypes.c_ulong(self.thread)
        at, undo, given = frame.f_lasti, (thread, _NOTHING), (thread, _NO_ANSWER)
        if frame.f_code.co_code[at] not in ENDS_AT:
            return False
        # Until here the thread may have gone on. From here to the call of C it cannot: no instruction in between lets
        # another thread run, none makes what the garbage collector counts. A frame that stands at a jump or at its
        # begin is the innermost one, for these call nothing: it asks for its turn there, and is given the exception
        # there, or does so before its call returns and takes the exception back.
        # Known: `while x: pass` is ended too; a loop of little but finalizers late, for Python drops what they raise.
        if frame.f_lasti == at and run in _running:
            run.undo = undo
            _raise(*given)
            return True
        return False


def _frames(frame: FrameType | None) -> list[FrameType] | None:
    """Those of the innermost call in a thread, the innermost first; None where there is none."""
    frames = list[FrameType]()
    while frame is not None:
        if frame.f_code is call.__code__:
            return frames
        frames.append(frame)
        frame = frame.f_back
    return None


def _has_to_end(code: CodeType) -> bool:
    return code.co_name in RUN_TO_THEIR_ENDS or "importlib" in code.co_filename


def _named(frames: Sequence[FrameType]) -> str:
    if not frames:
        return "a function in C"
    code = frames[-1].f_code
    return f"{code.co_qualname} ({Path(code.co_filename).name}, line {code.co_firstlineno})"


@cache
def look_on() -> None:
    """Start the thread that looks on, once in each process."""
    Thread(target=_look_on, name="harness-limit", daemon=True).start()


def _look_on() -> None:
    watched, told = dict[_Run, _Watched](), set[str]()
    while True:
        watched = {run: it for run in {**_running} if (it := watched.get(run) or _first_seen(run))}
        is_due = [it.look(run, told) for run, it in watched.items()]
        sleep(LOOK_CLOSELY_EVERY if any(is_due) else LOOK_EVERY)


def _first_seen(run: _Run) -> _Watched | None:
    """None if it has returned."""
    # Nobody may ask for the clock of a thread that has ended. As long as its call runs it has not, and from here to the
    # call of C it does not go on, as above.
    if run not in _running:
        return None
    thread, longest = _running[run]
    clock = time.pthread_getcpuclockid(thread) if ENDS else 0
    return _Watched(thread, longest, clock, _cpu_time(clock), monotonic(), longest)


def _cpu_time(clock: int) -> float:
    """Zero where nobody can tell, as of a thread that has ended since."""
    with suppress(OSError):
        return time.clock_gettime(clock) if ENDS else 0.0
    return 0.0


def _after_fork() -> None:
    for run, (thread, _) in {**_running}.items():
        if thread != get_ident():
            del _running[run]
    if look_on.cache_info().currsize:
        look_on.cache_clear()
        look_on()


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_after_fork)

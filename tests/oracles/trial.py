"""One question to the program about an input that was made, and what may be answered."""

import contextlib
import io
import json
import math
import re
import signal
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from harness.cli import main

USAGE, DAMAGED = 2, 1
UNSEEN = 1e-9
"""Numbers that differ by a smaller share are the same: sums are taken in another order."""

SECONDS = 5.0
"""Of processor time. An answer to inputs as small as these is there in a fraction of it."""

Answer = Mapping[str, Any]


class Shown(float):
    """A number that the program shows rounded to 0.1."""


class Refused(Exception):
    """The program said in a line that it does not read the input."""


class TookTooLong(BaseException):
    """The program was still at work after `SECONDS`. No `except Exception` takes it for an error of its own."""


@dataclass(frozen=True)
class Trial:
    """An input, a question, and what is right.

    Attributes:
        change: What was changed, in words.
        ask: Asks the program; raises `Refused`.
        right: Each of these is right to answer. Without any the input has to be refused.
        may_refuse: Whether a refusal is right beside them.
        tells: A pattern of what has to be told beside the answer; empty if nothing has to be.
    """

    change: str
    ask: Callable[[], tuple[Answer, str]]
    right: Sequence[Answer] = ()
    may_refuse: bool = False
    tells: str = ""


# An oracle makes an input in an empty folder, changes it, and says what is right, all by random numbers it is given.


def fault_of(trial):
    """What is wrong with what the program answers; None if nothing is."""
    try:
        with _limited():
            answer, said = trial.ask()
    except TookTooLong:
        fault = f"no answer within {SECONDS:g} s of processor time"
    except Refused as refusal:
        fault = f"refused, and {trial.right[0]} is right: {refusal}" if trial.right and not trial.may_refuse else ""
    except Exception as error:  # the program may raise anything
        fault = f"raised {error!r}"
    else:
        fault = _fault_in(answer, said, trial)
    return f"{trial.change}: {fault}" if fault else None


def _fault_in(answer, said, trial):
    if not trial.right:
        return f"read as {answer}, and has to be refused"
    if not any(is_same(answer, right) for right in trial.right):
        return f"answered {answer}, right is {' or '.join(map(str, trial.right))}"
    if trial.tells and not re.search(trial.tells, said):
        return f"answered without a word on it, /{trial.tells}/"
    return ""


@contextlib.contextmanager
def _limited():
    """Raises `TookTooLong` where the block does not end."""

    def stop(number, frame):
        raise TookTooLong

    before = signal.signal(signal.SIGPROF, stop)
    signal.setitimer(signal.ITIMER_PROF, SECONDS, 0.1)  # again: Python ignores what is raised while it cleans up
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0.0)
        signal.signal(signal.SIGPROF, before)


def is_same(one, other):
    """Whether two answers are the same, numbers but for rounding. Only what `other` names is looked at."""
    if isinstance(other, Mapping):
        return isinstance(one, Mapping) and all(key in one and is_same(one[key], other[key]) for key in other)
    if isinstance(other, list | tuple):
        return (
            isinstance(one, list | tuple)
            and len(one) == len(other)
            and all(is_same(*pair) for pair in zip(one, other, strict=True))
        )
    if isinstance(other, Shown) and isinstance(one, int | float):
        return abs(one - other) <= 0.05 + UNSEEN
    if isinstance(other, float) and isinstance(one, int | float):
        return math.isclose(one, other, rel_tol=UNSEEN, abs_tol=UNSEEN)
    return bool(one == other)


def call(*arguments):
    """What a command prints on standard output and on standard error.

    What is damaged may be left out, if that is told.

    Raises:
        Refused: It ends as a usage error does, with one line.
        AssertionError: It ends in another way.
    """
    out, err = io.StringIO(), io.StringIO()
    status = None
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        try:
            main([str(argument) for argument in arguments])
        except SystemExit as ended:
            status = ended.code
    said = err.getvalue().strip()
    if status in {USAGE, DAMAGED} and said and "\n" not in said and not out.getvalue():
        raise Refused(said)
    assert status == 0 or (status == DAMAGED and (said or out.getvalue())), f"status {status}: {said[-500:]}"
    return out.getvalue(), said


def call_json(*arguments):
    """What a command tells as JSON, and all its text."""
    out, said = call(*arguments, "--json")
    return json.loads(out), f"{out}\n{said}"

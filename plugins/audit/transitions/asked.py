"""A reward that is asked about transitions that nobody took."""

from collections.abc import Callable
from typing import Any

from harness.errors import reason_of
from harness.recorder.column import made_columns
from harness.recorder.guard import Guard
from harness.reward.given import Before
from harness.reward.steps import BEFORE, ENDS, MissingField, steps_type

OfTransition = Callable[[Any, Any, Any], float]
"""R(s, a, s')."""
_Now, _Before = steps_type((*Before._fields, BEFORE)), steps_type(("observation",))


class NoTransitionReward(Exception):
    """A reward cannot be asked about transitions that nobody took; the message says why."""


TAKEN = "which only a step that was taken has"


class _Closed(dict[str, Any]):
    """The info of a transition that nobody took: there is none, and who reads it is told."""

    def _refuse(self, *_: Any, **__: Any) -> Any:
        raise NoTransitionReward(f"it reads info, {TAKEN}")

    __getitem__ = __contains__ = __iter__ = __len__ = __bool__ = __eq__ = __or__ = __setitem__ = _refuse
    __hash__ = None  # as of any dict
    get = keys = values = items = pop = copy = setdefault = update = _refuse


_CLOSED = _Closed()


def of_transition(name: str, given: Any) -> OfTransition:
    """The reward as a function of a transition.

    Args:
        name: What it is called.
        given: What the user gave for it.

    Raises:
        NoTransitionReward: It is no function, or has a memory.
    """
    if isinstance(given, str):
        told = "what the env pays" if given == "own" else f"info key {given!r}"
        raise NoTransitionReward(f"it is {told}, {TAKEN}")
    (column,) = made_columns(None, {name: given}, {}, 1, frozenset())
    if column.remembers:
        raise NoTransitionReward("it has a memory, so that what it pays depends on more than one transition")
    guard = Guard()

    def pay(state: Any, action: Any, following: Any) -> float:
        step = _Now._make((following, action, _CLOSED, _Before._make((state,))))
        try:
            return column.numbers(guard.answer(column.given, column.arguments(step), column.is_watched))[0]
        except NoTransitionReward:
            raise
        except MissingField as error:
            if error.field not in (*Before._fields, *ENDS):
                raise NoTransitionReward(str(error)) from error
            told = f"it reads {error.field if error.field in ENDS else f'{BEFORE}.{error.field}'}"
            raise NoTransitionReward(f"{told}, {TAKEN}") from error
        except Exception as error:  # whatever rewards of users raise
            raise NoTransitionReward(
                f"asked about another step than the one taken, it fails: {reason_of(error)}"
            ) from error

    return pay

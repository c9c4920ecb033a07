"""A reward that is asked about transitions that nobody took."""

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from harness import Float
from harness.errors import reason_of
from harness.recorder.column import made_columns
from harness.recorder.guard import Guard
from harness.recorder.recorder import differs
from harness.recorder.sealed import Walk
from harness.reward.given import Before
from harness.reward.steps import BEFORE, ENDS, MissingField, steps_type

OfTransition = Callable[[Any, Any, Any], float]
"""R(s, a, s')."""
_Now, _Before = steps_type((*Before._fields, BEFORE)), steps_type(("observation",))


class NoTransitionReward(Exception):
    """A reward cannot be asked about transitions that nobody took; the message says why."""


class _Closed(dict[str, Any]):
    """The info of a transition that nobody took: there is none, and who reads it is told."""

    def _refuse(self, *_: Any, **__: Any) -> Any:
        raise NoTransitionReward("it reads info, which only a step that was taken has")

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
        raise NoTransitionReward(f"it is {told}, which only a step that was taken has")
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
            raise NoTransitionReward(f"{told}, which only a step that was taken has") from error
        except Exception as error:  # whatever rewards of users raise
            raise NoTransitionReward(
                f"asked about another step than the one taken, it fails: {reason_of(error)}"
            ) from error

    return pay


def of_transitions(
    rewards: Mapping[str, Any], walks: list[Walk], paid: Mapping[str, Float]
) -> tuple[dict[str, OfTransition], dict[str, str]]:
    """The rewards that are functions of a transition; and why the others are not.

    Args:
        rewards: By name, as the user gave them.
        walks: Episodes.
        paid: What each reward paid for their steps when they were taken, in order, (steps,).
    """
    pays: dict[str, OfTransition] = {}
    reasons: dict[str, str] = {}
    for name, given in rewards.items():
        try:
            pay = of_transition(name, given)
            with np.errstate(all="ignore"):  # what is not finite is refused
                again = np.array(
                    [pay(*step) for it in walks for step in zip(it.states, it.actions, it.states[1:], strict=False)]
                )
            if differs(again, paid[name]).any():
                raise NoTransitionReward(
                    "asked again about a step, it pays something else: it looks at more than the transition"
                )
            pays[name] = pay
        except NoTransitionReward as error:
            reasons[name] = str(error)
    return pays, reasons

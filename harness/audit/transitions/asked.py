"""A reward that is asked about transitions that nobody took."""

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from harness.arrays import Float
from harness.errors import one_line
from harness.recorder.column import as_number
from harness.recorder.computing import only_computes
from harness.recorder.guard import Guard
from harness.recorder.recorder import differs
from harness.recorder.walk import Walk

Pay = Callable[[Any, Any, Any], float]
"""R(s, a, s')."""


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


def pay_of(name: str, given: Any) -> Pay:
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
    if callable(getattr(given, "reset", None)):
        raise NoTransitionReward("it has a memory, so that what it pays depends on more than one transition")

    guard, is_watched = Guard(), not only_computes(given)

    def pay(state: Any, action: Any, following: Any) -> float:
        try:
            return as_number(guard.answer(given, (state, action, following, _CLOSED), is_watched))
        except NoTransitionReward:
            raise
        except Exception as error:  # whatever rewards of users raise
            raise NoTransitionReward(
                f"asked about another step than the one taken, it fails: {one_line(error)}"
            ) from error

    return pay


def pays_of(
    rewards: Mapping[str, Any], walks: list[Walk], paid: Mapping[str, Float]
) -> tuple[dict[str, Pay], dict[str, str]]:
    """The rewards that are functions of a transition; and why the others are not.

    Args:
        rewards: By name, as the user gave them.
        walks: Episodes.
        paid: What each reward paid for their steps when they were taken, in order, (steps,).
    """
    pays: dict[str, Pay] = {}
    reasons: dict[str, str] = {}
    for name, given in rewards.items():
        try:
            pay = pay_of(name, given)
            _require_same(pay, walks, paid[name])
            pays[name] = pay
        except NoTransitionReward as error:
            reasons[name] = str(error)
    return pays, reasons


def _require_same(pay: Pay, walks: list[Walk], paid: Float) -> None:
    """Asked again, it pays the same: it looks at nothing but the transition."""
    with np.errstate(all="ignore"):  # what is not finite is refused
        again = np.array(
            [pay(*step) for walk in walks for step in zip(walk.states, walk.actions, walk.states[1:], strict=False)]
        )
    if differs(again, paid).any():
        raise NoTransitionReward(
            "asked again about a step, it pays something else: it looks at more than the transition"
        )

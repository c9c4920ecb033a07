"""Makes a `harness.reward.Reward` of what a user wrote: one adapter for each form, at the door.

An arm's reward may be a frozen dataclass with ``initial_carry``, which is one already, or a plain function of a step::

    def gentle(step):
        return {"reach": -step.distance, "effort": -0.01 * (step.action**2).sum(-1)}
"""

import dataclasses
import inspect
import keyword
from collections.abc import Callable, Mapping
from functools import cache
from typing import Annotated, Any

from pydantic import Field

from harness.errors import UsageError
from harness.reward.carry import Carry
from harness.reward.needs import needs_of
from harness.reward.reward import LARGEST_FACTOR, Reward
from harness.reward.steps import Steps
from harness.reward.terms import paid_of

STEP = "step"
"""What the one argument of a function of steps is called."""
FUNCTION = "_function"
MEMBERS = ("needs", "initial_carry", FUNCTION)
"""What a reward has beside its parameters."""
Weight = Annotated[
    float, Field(ge=-LARGEST_FACTOR, le=LARGEST_FACTOR, description="weight of the term: what it pays is times this")
]


def is_function_of_steps(found: Any) -> bool:
    """Whether something is a plain function whose one argument without a default is called ``step``."""
    if not inspect.isfunction(found):
        return False
    needed = [it for it in inspect.signature(found).parameters.values() if it.default is it.empty]
    return len(needed) == 1 and needed[0].name == STEP and needed[0].kind is not inspect.Parameter.KEYWORD_ONLY


@cache
def reward_class(function: Callable[[Steps], Any]) -> type[Reward]:
    """A frozen dataclass that is the reward of a function of steps. Its fields are the weights of the terms.

    Args:
        function: It returns what the steps are paid, or a dict of terms, or (total, dict). It is called once, on
            made-up steps, to learn its terms.

    Raises:
        UsageError: It fails, or reads what a step of an arm does not have.
    """
    plain = dataclasses.make_dataclass("Plain", [], frozen=True, namespace=_members(function, _call_plain(function)))
    try:
        needs = needs_of(plain())
    except UsageError as error:
        raise UsageError(f"Reward '{function.__name__}': {error}") from error
    fields = [(name, Weight, dataclasses.field(default=1.0)) for name in needs.terms if _can_be_weighted(name)]
    call = _call_weighted(function) if needs.terms else _call_plain(function)
    members = {**_members(function, call), "needs": frozenset(needs.fields)}
    made: type[Reward] = dataclasses.make_dataclass(function.__name__, fields, frozen=True, namespace=members)
    made.__module__, made.__qualname__ = function.__module__, function.__qualname__
    return made


def is_plain_function(reward: Any) -> bool:
    """Whether a reward was written as a plain function of a step."""
    return hasattr(type(reward), FUNCTION)


def weighted(terms: Mapping[str, Any], weights: Mapping[str, float]) -> dict[str, Any]:
    """Terms times their weights; one of weight 1, or without a weight, stays what it is to the last bit."""
    return {
        name: value if (weight := weights.get(name, 1.0)) == 1.0 else weight * value for name, value in terms.items()
    }


def _can_be_weighted(term: str) -> bool:
    """Whether a term's name can be that of a parameter."""
    return term.isidentifier() and not keyword.iskeyword(term) and term not in MEMBERS


def _members(function: Callable[..., Any], call: Callable[..., Any]) -> dict[str, Any]:
    own = {"__doc__": function.__doc__, FUNCTION: staticmethod(function)}
    return {**own, "initial_carry": lambda self, begin_distance: (), "__call__": call}


def _call_plain(function: Callable[..., Any]) -> Callable[..., Any]:
    def call(self: Any, carry: Carry, steps: Steps) -> tuple[Carry, Any]:
        return carry, function(steps)

    return call


def _call_weighted(function: Callable[..., Any]) -> Callable[..., Any]:
    def call(self: Any, carry: Carry, steps: Steps) -> tuple[Carry, Any]:
        terms = paid_of(function(steps)).terms
        return carry, weighted(terms, vars(self))

    return call

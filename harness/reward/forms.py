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
from harness.reward.reward import Carry, Pay, Reward
from harness.reward.steps import Steps
from harness.reward.terms import Needs, Paid, needs_of, paid_of, sum_of

STEP = "step"
"""What the one argument of a function of steps is called."""
FUNCTION = "_function"
FAILED = "failed"
"""The attribute of a reward's class that says why the function failed on made-up steps; empty if it did not."""
MEMBERS = ("needs", FAILED, "initial_carry", FUNCTION)
"""What a reward has beside its parameters."""
Weight = Annotated[Pay, Field(description="weight of the term: what it pays is times this")]


def takes_alone(found: Any, argument: str) -> bool:
    """Whether something is a plain function whose one argument without a default has this name."""
    return inspect.isfunction(found) and needs_alone(found, argument)


def needs_alone(found: Any, argument: str) -> bool:
    """Whether something that can be called has one argument without a default, and that has this name."""
    try:
        known = inspect.signature(found).parameters.values()
    except (TypeError, ValueError):  # a built-in: Python does not know its arguments
        return False
    needed = [it for it in known if it.default is it.empty and it.kind not in (it.VAR_POSITIONAL, it.VAR_KEYWORD)]
    return len(needed) == 1 and needed[0].name == argument and needed[0].kind is not inspect.Parameter.KEYWORD_ONLY


def takes_step(found: Any) -> bool:
    """Whether something that can be called takes a step."""
    return needs_alone(found, STEP)


@cache
def reward_class(function: Callable[[Steps], Any]) -> type[Reward]:
    """A frozen dataclass that is the reward of a function of steps. Its fields are the weights of the terms.

    To learn the terms it is called once, on made-up steps. One that fails there has no weights, and `FAILED` says why;
    it fails again where it is to pay.

    Args:
        function: It returns what the steps are paid, or a dict of terms, or (total, dict).
    """

    def call(self: Any, carry: Carry, steps: Steps) -> tuple[Carry, Any]:
        weights, returned = vars(self), function(steps)
        if {*weights.values()} <= {1.0}:
            return carry, returned
        terms = weighted(paid_of(returned).terms, weights)
        return carry, Paid(sum_of(terms), terms)

    members: dict[str, Any] = {"__doc__": function.__doc__, FUNCTION: staticmethod(function), "__call__": call}
    members["initial_carry"] = lambda self, begin_distance: ()
    plain = dataclasses.make_dataclass("Plain", [], frozen=True, namespace=members)
    needs, failed = Needs(), ""
    try:
        needs = needs_of(plain())
    except UsageError as error:
        failed = f"Reward '{function.__name__}': {error}"
    fields = [
        (name, Weight, dataclasses.field(default=1.0))
        for name in needs.terms
        if name.isidentifier() and not keyword.iskeyword(name) and name not in MEMBERS
    ]
    members |= {"needs": frozenset(needs.fields), FAILED: failed}
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

"""What an author gives for a reward or a measure of an environment, and the one way in which it is called.

Behind the door all of it is a function of a step: one step of one env, with the fields of
`harness.reward.steps.ENVIRONMENT`, or of a batch of envs. What an author gives is one of these:

* a function whose one argument is called ``step``; it returns a number, or of a reward also terms, see
  `harness.reward.terms.paid_of`.
* a function of `ARGUMENTS`, which returns the same. Either may be an object with ``reset()``, which has a memory.
* a key of ``info``, ``"distance"``, or of a dict in it, ``"reward.forward"``; ``"own"`` for what the env itself pays.
* of a reward, its terms by name, each of them a function or a key: ``{"forward": "reward_forward"}``.
"""

import copy
import inspect
import math
from collections.abc import Callable, Collection, Iterable, Mapping
from typing import Any, TypeAlias

import numpy as np

from harness.errors import UsageError
from harness.reward.forms import STEP, takes_step, weighted
from harness.reward.reward import LARGEST_FACTOR, Reward
from harness.reward.steps import BEFORE, ENVIRONMENT, Steps, nearest, rows_of, steps_type
from harness.reward.terms import paid_of, pay

Given: TypeAlias = Callable[..., Any] | str | Mapping[str, Callable[..., Any] | str]
"""A function, a key of ``info``, ``"own"``, or terms by name."""
OWN = "own"
"""What the env itself pays."""
ARGUMENTS = "(observation, action, next_observation, info)"
FIELDS = tuple(field.name for field in ENVIRONMENT)
Before = steps_type(tuple(field.name for field in ENVIRONMENT if field.before))
"""What there was before a step: the observation, the action and the info of the step before."""
Now = steps_type((*FIELDS, BEFORE))
"""A step: the observation after it, the action, the info, whether it ended the episode, and `Before`."""
STEP_PARTS = (*(f"{STEP}.{name}" for name in FIELDS), *(f"{STEP}.{BEFORE}.{name}" for name in Before._fields))
"""The fields of both, as a function of a step reads them."""


ARM = "arm"
"""The key of ``info`` under which an env of an arm tells what an arm's reward is given of its step, a row for each
environment step; and of the metadata that say that it does."""
TASK = "task"
"""The key of ``info``, and the term, of what the arm's task pays beside the reward."""


class Untold(KeyError):
    """``info``, or another dict that a step has, lacks a key."""

    def __init__(self, key: Any, there: Iterable[Any]) -> None:
        super().__init__(key, tuple(there))

    def __str__(self) -> str:
        key, there = self.args
        told = ", ".join(map(repr, there)) or "nothing"
        return f"info has no {key!r}; it has {told}{nearest(str(key), tuple(map(str, there)))}"


def told_under(info: Mapping[str, Any], key: str) -> Any:
    """What info tells under a key; ``reward.forward`` is the key ``forward`` of the dict ``reward``.

    Raises:
        Untold: Nothing.
    """
    if key in info:
        return info[key]
    first, dot, rest = key.partition(".")
    while dot:
        if isinstance(info.get(first), Mapping):
            return told_under(info[first], rest)
        more, dot, rest = rest.partition(".")
        first = f"{first}.{more}"
    raise Untold(key, info)


def takes_arguments(found: Any) -> bool:
    """Whether something can be called with `ARGUMENTS`, or may be, as far as Python knows."""
    try:
        inspect.signature(found).bind(*[None] * 4)
    except TypeError:
        return False
    except ValueError:  # a built-in: calls will tell
        return True
    return True


def arguments(step: Steps, is_of_step: bool) -> tuple[Any, ...]:
    """What an author's function is called with about a step: it, or `ARGUMENTS`."""
    return (step,) if is_of_step else (step.before.observation, step.action, step.observation, step.info)


def zeros_of(action: Any) -> Any:
    """An action of the same form, all zeros: what there was before the first step of an episode."""
    if isinstance(action, Mapping):
        return {key: zeros_of(part) for key, part in action.items()}
    if isinstance(action, tuple | list):
        make = getattr(action, "_make", type(action))
        return make(map(zeros_of, action))
    if isinstance(action, np.ndarray) and not action.dtype.hasobject:
        zeros = np.zeros_like(action)
        zeros.setflags(write=False)
        return zeros
    return type(action)() if isinstance(action, int | float | str | np.generic) else action


class Terms:
    """A reward whose terms were given by name, or one that weighs the terms of another one.

    Attributes:
        parts: The terms by name; of a reward that weighs, the other reward under the name that it has.
        weights: By term, what it is multiplied by; others are paid as they are.
    """

    def __init__(self, parts: Mapping[str, Callable[..., Any] | str], weights: Mapping[str, float] | None = None):
        """Begin nothing yet.

        Args:
            parts: Functions or keys of info.
            weights: Of one reward's terms; None for a reward that has `parts` as its terms.
        """
        self.parts, self.weights = dict(parts), weights
        if any(callable(getattr(part, "reset", None)) for part in self.parts.values()):
            self.reset = self._reset

    def __call__(self, step: Steps) -> Mapping[str, Any]:
        """What each term pays."""
        told = {name: part(step) for name, part in self._asked().items()}
        if self.weights is None:
            return told
        (returned,) = told.values()
        terms = paid_of(returned).terms
        # In double precision, as terms are recorded: so the same is paid by what was recorded of them.
        return weighted({term: np.asarray(value, np.float64)[()] for term, value in terms.items()}, self.weights)

    def _asked(self) -> dict[str, Callable[[Steps], Any]]:
        asked = vars(self).get("_functions")
        if asked is None:  # not in a copy that was made before the first call
            asked = self._functions = {name: _part(given) for name, given in self.parts.items()}
        return asked

    def _reset(self, *given: Any) -> None:
        for part in self.parts.values():
            if callable(getattr(part, "reset", None)):
                part.reset(*given)  # type: ignore[union-attr] # it has one

    def __deepcopy__(self, memo: dict[int, Any]) -> "Terms":
        return Terms({name: copy.deepcopy(part, memo) for name, part in self.parts.items()}, self.weights)


class OfArm:
    """An arm's reward as one of an env that tells its steps, see `ARM`. What the task pays is added, as by the env.

    Attributes:
        reward: The arm's.
    """

    def __init__(self, reward: Reward) -> None:
        self.reward = reward
        self.reset()

    def reset(self) -> None:
        """Forget what was before."""
        self._begin, self._carry = math.nan, None

    def __call__(self, step: Steps) -> Any:
        """What the step pays; of a reward with terms these, and what the task pays."""
        arm, paid = step.info[ARM], []
        for row, begin in enumerate(arm.begin_distance.tolist()):
            if begin != self._begin:  # the first target, or the next one
                self._begin, self._carry = begin, self.reward.initial_carry(arm.begin_distance[row : row + 1])
            self._carry, told = pay(self.reward, self._carry, rows_of(arm, slice(row, row + 1)))
            paid.append(told)
        terms = {name: sum(it.terms[name][0] for it in paid) for name in paid[0].terms}
        return {**terms, TASK: step.info[TASK]} if terms else sum(it.total[0] for it in paid) + step.info[TASK]


def _part(given: Callable[..., Any] | str) -> Callable[[Steps], Any]:
    if isinstance(given, str):
        return lambda step: told_under(step.info, given)
    is_of_step = takes_step(given)
    return lambda step: given(*arguments(step, is_of_step))


def opened(given: Any, noun: str) -> Any:
    """What an author gave, as it is called or read behind the door: a key, or something that can be called.

    Args:
        given: A `Given`.
        noun: What messages call it, ``reward 'v1'``.

    Raises:
        UsageError: It is none.
    """
    if isinstance(given, str):
        return given
    if isinstance(given, Mapping):
        if not given:
            raise UsageError(f"{noun} has no term: give at least one, {{'forward': 'reward_forward'}}")
        for term, part in given.items():
            if isinstance(part, Mapping) or (isinstance(part, str) and part == OWN):
                raise UsageError(f"{noun}: its term {term!r} is {part!r}: give a function, or a key of info in quotes")
            opened(part, f"{noun}, term {term!r}")
        return Terms(given)
    if not callable(given) or isinstance(given, type):
        raise UsageError(
            f"{noun} is {given!r}: it has to be a function of ({STEP}) or of {ARGUMENTS}, a key of info in quotes, "
            f"or {OWN!r}; or terms by name, {{'forward': 'reward_forward'}}"
        )
    if not (takes_step(given) or takes_arguments(given)):
        raise UsageError(f"{noun} takes {inspect.signature(given)}: it has to take ({STEP}), or {ARGUMENTS}")
    return given


def weights_of(reward: str, given: Mapping[str, Any], terms: Collection[str]) -> dict[str, float]:
    """What a user gave for the weights of a reward's terms, as numbers in the terms' order, without those that are 1.

    Raises:
        UsageError: It names another term, or what it gives is no weight; names the terms, and the nearest.
    """
    found: dict[str, float] = {}
    for term, weight in given.items():
        if term not in terms:
            has = (
                f"It has: {', '.join(terms)}{nearest(term, tuple(terms))}"
                if terms
                else "It pays a number without terms"
            )
            raise UsageError(f"Reward '{reward}' has no term '{term}' to weigh. {has}")
        try:
            found[term] = float(weight)
        except (TypeError, ValueError):
            found[term] = math.nan
        if not abs(found[term]) <= LARGEST_FACTOR:
            raise UsageError(
                f"Reward '{reward}': {term}={weight} is no weight: give a number from -{LARGEST_FACTOR:g} to "
                f"{LARGEST_FACTOR:g}, as in {reward}:{term}=5"
            )
    return {term: found[term] for term in terms if found.get(term, 1.0) != 1.0}

"""Pays recorded steps by other weights of the terms that were recorded, without the code of the reward.

A label such as ``gentle:effort=5`` tells the weight of each term: `harness.reward.forms` makes the weights the
parameters of a function of steps, 1 where the label does not name them. A recorded column holds the term times its
weight, so that another weight is a matter of one factor.
"""

import math
from collections.abc import Callable, Iterable, Mapping
from typing import NamedTuple

from harness.arrays import Float
from harness.errors import UsageError
from harness.registry.choice import Choice, label_of, parse
from harness.registry.names import did_you_mean
from harness.reward import LARGEST_FACTOR, Paid
from harness.reward.terms import sum_of


def name_of(label: str) -> str:
    """The name of a reward, without its parameters."""
    return label.partition(":")[0]


def weighted_label(asked: str, terms: Iterable[str]) -> str:
    """The label of a reward whose weights are told, as a run by it has it: weights of 1 left out, in the terms' order.

    Raises:
        UsageError: It names no term of these, or what it gives is no weight.
    """
    weights = _weights(asked, list(terms))
    return label_of(name_of(asked), {term: weights[term] for term in terms if weights.get(term, 1.0) != 1.0})


def recorded_choice(label: str) -> Choice:
    """The reward of a column, of which nothing is known but its label."""
    return Choice(name_of(label), (), label)


def reweighted(asked: str, recorded: Choice, terms: Mapping[str, Float]) -> Paid:
    """What a reward pays with other weights: its terms, and their sum.

    Args:
        asked: The reward with the weights that are asked for, ``gentle:effort=0.05``.
        recorded: The same reward with the weights that it was recorded with.
        terms: What its terms paid then, (rows,) each, in their order.

    Raises:
        UsageError: It names no term of these, what it gives is no weight, a term was recorded with the weight 0, or the
            parameters of the reward are no weights.
    """
    if asked == recorded.label:
        return Paid(sum_of(terms), terms)
    names = list(terms)
    if not _are_weights(recorded, names):
        raise UsageError(
            f"The parameters of '{recorded.name}' are not the weights of its terms, so that its recorded columns do "
            f"not tell what '{asked}' pays: give its file, --plugin FILE"
        )
    now, then = _weights(asked, names), _weights(recorded.label, names)
    paid = {name: _times(values, name, now.get(name, 1.0), then.get(name, 1.0)) for name, values in terms.items()}
    return Paid(sum_of(paid), paid)


class RecordedTerms(NamedTuple):
    """Columns of the terms of a reward."""

    reward: Choice
    """The reward, with the weights that it was recorded with."""
    terms: tuple[str, ...]
    read: Callable[[], Mapping[str, Float]]
    """A function that reads them, by term, (rows,) each."""


def weighted_pay(asked: str, recorded: Iterable[RecordedTerms], who: str) -> tuple[Choice, Paid]:
    """What a reward pays with other weights, from the first recorded columns of its terms that tell it, and which.

    Args:
        asked: The reward with the weights that are asked for.
        recorded: Where its terms are recorded.
        who: Begins the sentence that says that they are nowhere, ``these steps have``.

    Raises:
        UsageError: They are nowhere, or as `reweighted`.
    """
    refused: UsageError | None = None
    for found in recorded:
        try:
            return found.reward, reweighted(asked, found.reward, found.read())
        except UsageError as error:  # a term was recorded with the weight 0, and elsewhere perhaps with another
            refused = refused or error
    raise refused or UsageError(
        f"{who} no columns of the terms of '{name_of(asked)}': give its file, --plugin FILE, and it is called"
    )


def _are_weights(choice: Choice, terms: Iterable[str]) -> bool:
    """Whether the parameters of a reward are the weights of its terms, as those of a function of steps are.

    Each has the name of a term, and is left out of the label where it is 1, and nowhere else.
    """
    told, known = parse(choice.label)[1], {*terms}
    params = dict(choice.params)
    return {*told, *params} <= known and all((name in told) == (value != 1.0) for name, value in params.items())


def _times(values: Float, name: str, now: float, then: float) -> Float:
    if now == then:
        return values
    if then == 0.0:
        raise UsageError(
            f"The term '{name}' was recorded with the weight 0, which cannot be undone: give the reward's file, "
            "--plugin FILE"
        )
    return values * (now / then)


def _weights(label: str, terms: list[str]) -> dict[str, float]:
    name, params = parse(label)
    for term in params:
        if term not in terms:
            raise UsageError(
                f"No term '{term}' of the reward '{name}'. There is: {', '.join(terms)}.{did_you_mean(term, terms)}"
            )
    return {term: _weight(term, text) for term, text in params.items()}


def _weight(term: str, text: str) -> float:
    try:
        weight = float(text)
    except ValueError:
        weight = math.nan
    if not abs(weight) <= LARGEST_FACTOR:
        raise UsageError(
            f"The weight of '{term}' is '{text}': give a number from -{LARGEST_FACTOR:g} to {LARGEST_FACTOR:g}"
        )
    return weight

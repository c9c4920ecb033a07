"""Pays recorded steps by other weights of the terms that were recorded, without the code of the reward.

A label such as ``gentle:effort=5`` tells the weight of each term: `harness.reward.forms` makes the weights the
parameters of a function of steps, 1 where the label does not name them. A recorded column holds the term times its
weight, so that another weight is a matter of one factor.
"""

import math
from collections.abc import Collection, Mapping

from harness.arrays import Float
from harness.errors import UsageError
from harness.registry.choice import Choice, label_of, parse
from harness.registry.spec import did_you_mean
from harness.reward import LARGEST_FACTOR, Paid
from harness.reward.terms import sum_of


def name_of(label: str) -> str:
    """The name of a reward, without its parameters."""
    return label.partition(":")[0]


def weighted_label(asked: str, terms: Collection[str]) -> str:
    """The label of a reward whose weights are told, as a run by it has it: weights of 1 left out, in the terms' order.

    Raises:
        UsageError: It names no term of these, or what it gives is no weight.
    """
    weights = _weights(asked, terms)
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
    told, params = parse(recorded.label)[1], dict(recorded.params)
    # Each weight has the name of a term, and is left out of the label where it is 1, and nowhere else.
    are_weights = all((name in told) == (value != 1.0) for name, value in params.items())
    if not are_weights or not {*told, *params} <= terms.keys():
        raise UsageError(
            f"The parameters of '{recorded.name}' are not the weights of its terms, so that its recorded columns do "
            f"not tell what '{asked}' pays: give its file, --plugin FILE"
        )
    now, then, paid = _weights(asked, terms), _weights(recorded.label, terms), dict(terms)
    for name in {**now, **then}:
        wanted, was = now.get(name, 1.0), then.get(name, 1.0)
        if wanted != was and was == 0.0:
            raise UsageError(
                f"The term '{name}' was recorded with the weight 0, which cannot be undone: give the reward's file, "
                "--plugin FILE"
            )
        if wanted != was:
            paid[name] = terms[name] * (wanted / was)
    return Paid(sum_of(paid), paid)


def no_terms(who: str, name: str) -> str:
    """Says that the terms of a reward are not recorded, and what to do; `who` has none, ``these trainings have``."""
    return f"{who} no columns of the terms of '{name}': give its file, --plugin FILE, and it is called"


def _weights(label: str, terms: Collection[str]) -> dict[str, float]:
    name, params = parse(label)
    found: dict[str, float] = {}
    for term, text in params.items():
        if term not in terms:
            raise UsageError(
                f"No term '{term}' of the reward '{name}'. There is: {', '.join(terms)}.{did_you_mean(term, terms)}"
            )
        try:
            found[term] = float(text)
        except ValueError:
            found[term] = math.nan
        if not abs(found[term]) <= LARGEST_FACTOR:
            raise UsageError(
                f"The weight of '{term}' is '{text}': give a number from -{LARGEST_FACTOR:g} to {LARGEST_FACTOR:g}"
            )
    return found

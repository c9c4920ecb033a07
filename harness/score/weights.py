"""Pays recorded steps by other weights of the terms that were recorded, without the code of the reward.

A label such as ``gentle:effort=5`` tells the weight of each term: `harness.reward.forms` makes the weights the
parameters of a function of steps, 1 where the label does not name them. A recorded column holds the term times its
weight, so that another weight is a matter of one factor.
"""

from collections.abc import Collection, Iterable, Mapping

from harness.arrays import Float
from harness.errors import UsageError
from harness.registry.choice import Choice, label_of, parse
from harness.reward import Paid
from harness.reward.given import weights_of
from harness.reward.terms import sum_of


def name_of(label: str) -> str:
    """The name of a reward, without its parameters."""
    return label.partition(":")[0]


def label_by_terms(text: str, recorded: Iterable[tuple[str, Collection[str]]]) -> str:
    """The label of a reward with weights, ``gentle:effort=0.05``, as a run by it has it; empty if no terms tell it.

    Args:
        text: What the user typed.
        recorded: Labels of rewards, each with its terms.

    Raises:
        UsageError: It names no term of the reward, or what it gives is no weight.
    """
    name, params = parse(text)
    told = (label_of(name, weights_of(name, params, terms)) for label, terms in recorded if name_of(label) == name)
    return next(told, "")


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
    told, params = parse(recorded.label)[1], recorded.named
    # Each weight has the name of a term, and is left out of the label where it is 1, and nowhere else.
    are_weights = all((name in told) == (value != 1.0) for name, value in params.items())
    if not are_weights or not {*told, *params} <= terms.keys():
        raise UsageError(
            f"The parameters of '{recorded.name}' are not the weights of its terms, so that its recorded columns do "
            f"not tell what '{asked}' pays: give its file, --plugin FILE"
        )
    now, then = (weights_of(recorded.name, parse(it)[1], terms) for it in (asked, recorded.label))
    paid = dict(terms)
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

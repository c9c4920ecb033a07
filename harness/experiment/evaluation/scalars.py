"""The numbers of an evaluation as trackers get them, whatever was evaluated: an arm, or an environment of anybody."""

from collections.abc import Mapping
from types import MappingProxyType

from harness.progress import TERMS

SECTION, PAID = "Evaluation", "Cumulative Reward"
"""The first part of each name, and the name of what an episode was paid; both are those of Unity ML-Agents."""


NO_TERMS: Mapping[str, float | None] = MappingProxyType({})


def named_scalars(
    paid: float | None, measures: Mapping[str, float | None], terms: Mapping[str, float | None] = NO_TERMS
) -> dict[str, float]:
    """Numbers by their names for trackers, such as ``Evaluation/Success Rate``. What is None is left out.

    Args:
        paid: Mean over episodes of what the reward of the training paid.
        measures: Means over episodes of what no reward enters, by name, as ``success_rate``.
        terms: Means over episodes of what each term of that reward paid, by name.
    """
    values = {PAID: paid, **{name.replace("_", " ").title(): value for name, value in measures.items()}}
    values |= {f"{TERMS}/{name}": value for name, value in terms.items()}
    return {f"{SECTION}/{name}": float(value) for name, value in values.items() if value is not None}

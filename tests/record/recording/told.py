"""Columns of a recorded training by the names of its terms and measures."""

from collections.abc import Mapping

from harness.arrays import Float
from harness.log import Log


def terms_of(log: Log, reward: str) -> Mapping[str, Float]:
    """What each term of a reward paid, (steps,) each, in their order."""
    return {name: log[f"reward/{reward}/{name}"] for name in log.terms_of(reward)}

"""What an author of rewards imports; see `harness.reward.reward` for the interface."""

from harness.reward.given import Given
from harness.reward.reward import (
    LARGEST_FACTOR,
    LARGEST_PAID,
    Array,
    Carry,
    Reward,
    Selection,
    put,
    replace_where,
    take,
)
from harness.reward.steps import MissingField, Sample, Steps
from harness.reward.terms import Paid, pay

__all__ = [
    "LARGEST_FACTOR",
    "LARGEST_PAID",
    "Array",
    "Carry",
    "Given",
    "MissingField",
    "Paid",
    "Reward",
    "Sample",
    "Selection",
    "Steps",
    "pay",
    "put",
    "replace_where",
    "take",
]

"""One measure of behaviour under two rewards: the difference, and how far it can be trusted."""

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from harness.eta.statistics import FEW_SEEDS, draw_shares, p_value, percentile_interval


@dataclass(frozen=True)
class Change:
    """Means over seeds of one metric; no reward enters it.

    Attributes:
        name: Of the metric.
        unit: Of its values; empty where it has none.
        better: ``higher`` or ``lower``.
        baseline: Mean over seeds under the baseline; None where the metric is not defined.
        proposed: The same under the proposed reward.
        random: The same of random actions.
        seeds: How many seeds have a value under both rewards.
        low: Lower end of the 95 % interval of proposed - baseline, over seeds in pairs; None where there is none.
        high: Upper end.
        p: That there is no difference; None where it cannot be told.
    """

    name: str
    unit: str
    better: str
    baseline: float | None
    proposed: float | None
    random: float | None
    seeds: int
    low: float | None
    high: float | None
    p: float | None

    @property
    def direction(self) -> str:
        """``better``, ``worse``, or empty where the interval holds 0."""
        if self.low is None or self.high is None or self.low <= 0.0 <= self.high:
            return ""
        return "better" if (self.low > 0.0) == (self.better == "higher") else "worse"

    @property
    def sure(self) -> bool:
        """Whether enough seeds stand behind the direction."""
        return bool(self.direction) and self.seeds >= FEW_SEEDS

    def to_json(self) -> dict[str, Any]:
        """Plain data."""
        return asdict(self)


def change_of(
    name: str,
    unit: str,
    better: str,
    baseline: Sequence[float | None],
    proposed: Sequence[float | None],
    random: Sequence[float | None],
) -> Change:
    """The change of one metric; entry i of `baseline` and `proposed` has the same seed."""
    pairs = [(b, k) for b, k in zip(baseline, proposed, strict=True) if b is not None and k is not None]
    low = high = p = None
    if len(pairs) > 1:
        differences = np.array([k - b for b, k in pairs])
        draws = draw_shares(len(pairs)) @ differences
        low, high = percentile_interval(draws)
        p = p_value(draws, 0.0)
    means = (_mean(baseline), _mean(proposed), _mean(random))
    return Change(name, unit, better, *means, len(pairs), low, high, p)


def _mean(values: Sequence[float | None]) -> float | None:
    known = [value for value in values if value is not None]
    return float(np.mean(known)) if known else None

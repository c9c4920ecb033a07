"""What a panel of accumulated reward shows."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Protocol

import numpy as np

from harness.arrays import Float
from harness.eta.curve import GroupCurve
from harness.eta.index import Index
from harness.eta.scored_sums import BB, KK, Pair


class Curved(Protocol):
    """A comparison of two rewards whose curves can be drawn."""

    @property
    def baseline(self) -> str:
        """Label of the baseline reward."""

    @property
    def proposed(self) -> str:
        """Label of the proposed reward."""

    @property
    def seeds(self) -> tuple[int, ...]:
        """The seeds of the runs under each reward."""

    @property
    def curves(self) -> Mapping[Pair, GroupCurve]:
        """The curves of both trainings, at least each under its own reward."""

    @property
    def baseline_index(self) -> Index | None:
        """The index of the baseline's curves; None if there is nothing to draw."""

    @property
    def proposed_index(self) -> Index | None:
        """The same for the proposed reward."""


@dataclass(frozen=True, eq=False)
class CurvePanel:
    """The runs of one training under their own reward.

    Attributes:
        role: ``Baseline`` or ``Proposed``.
        reward: Its label.
        curve: The curves of its runs.
        seeds: The seed of each run.
        marks: Marked steps of the mean curve, by name. An event that never happens is left out.
    """

    role: str
    reward: str
    curve: GroupCurve
    seeds: tuple[int, ...]
    marks: Mapping[str, int]

    @cached_property
    def runs(self) -> Float:
        """Each run's accumulated reward, every `stride`-th step of it, (runs, points)."""
        return self.curve.runs

    @property
    def stride(self) -> int:
        """Steps from one point to the next."""
        return self.curve.stride

    @cached_property
    def mean(self) -> Float:
        """The mean over the runs, (points,)."""
        mean: Float = self.runs.mean(axis=0)
        return mean

    @property
    def heights(self) -> list[float]:
        """The height of the drawn mean curve at each mark."""
        steps = np.arange(len(self.mean)) * self.stride
        heights: list[float] = np.interp(list(self.marks.values()), steps, self.mean).tolist()
        return heights


def panels_of(combination: Curved) -> tuple[CurvePanel, CurvePanel] | None:
    """A panel for the baseline and one for the proposed reward; None without a finished pair."""
    baseline, proposed = combination.baseline_index, combination.proposed_index
    if baseline is None or proposed is None:
        return None
    curves, seeds = combination.curves, combination.seeds
    return (
        CurvePanel("Baseline", combination.baseline, curves[BB], seeds, _marks(baseline)),
        CurvePanel("Proposed", combination.proposed, curves[KK], seeds, _marks(proposed)),
    )


def step_range(panels: Sequence[CurvePanel]) -> tuple[float, float]:
    """The steps that all panels span."""
    return 0.0, float(max(panel.curve.index.steps for panel in panels) - 1)


def reward_range(panels: Sequence[CurvePanel]) -> tuple[float, float]:
    """The range from the lowest to the highest value of all panels and 0, with some margin."""
    low = min(0.0, *(float(panel.runs.min()) for panel in panels))
    high = max(0.0, *(float(panel.runs.max()) for panel in panels))
    air = 0.04 * (high - low) or 1.0
    return low - air, high + air


def _marks(index: Index) -> dict[str, int]:
    steps = {"first negative": index.first_negative, "cross-over": index.crossover}
    return {name: step for name, step in steps.items() if step is not None}

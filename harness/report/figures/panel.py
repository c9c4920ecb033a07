"""What a panel of accumulated reward shows."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple, Protocol

import numpy as np

from harness.arrays import Float
from harness.eta.curve import GroupCurve, Kind
from harness.eta.index import Index
from harness.eta.scored_sums import BB, KK, Pair
from harness.report.figures.points import POINTS, select_points


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


class Drawn(NamedTuple):
    """The points of a curve that are drawn, in order."""

    steps: Float
    values: Float


@dataclass(frozen=True, eq=False)
class CurvePanel:
    """The runs of one training under their own reward.

    Attributes:
        role: ``Baseline`` or ``Proposed``.
        reward: Its label.
        kind: Of the curves.
        index: Of the mean curve.
        seeds: The seed of each run.
        runs: The curve of each run.
        mean: Their mean.
    """

    role: str
    reward: str
    kind: Kind
    index: Index
    seeds: tuple[int, ...]
    runs: tuple[Drawn, ...]
    mean: Drawn

    @property
    def marks(self) -> dict[str, int]:
        """Marked steps of the mean curve, by name. An event that never happens is left out."""
        steps = {"first negative": self.index.first_negative, "cross-over": self.index.crossover}
        return {name: step for name, step in steps.items() if step is not None}

    @property
    def heights(self) -> list[float]:
        """The height of the drawn mean curve at each mark."""
        heights: list[float] = np.interp(list(self.marks.values()), *self.mean).tolist()
        return heights


def panel_of(
    role: str, reward: str, curve: GroupCurve, index: Index, seeds: tuple[int, ...], points: int = POINTS
) -> CurvePanel:
    """The panel of one training's curves, of which single runs have `points` points at most."""
    runs = curve.runs
    drawn = tuple(_drawn(run, curve.stride, points) for run in runs)
    return CurvePanel(role, reward, curve.kind, index, seeds, drawn, _drawn(runs.mean(axis=0), curve.stride, POINTS))


def panels_of(comparison: Curved, points: int = POINTS) -> tuple[CurvePanel, CurvePanel] | None:
    """A panel for the baseline and one for the proposed reward; None without a finished pair."""
    baseline, proposed = comparison.baseline_index, comparison.proposed_index
    if baseline is None or proposed is None:
        return None
    curves, seeds = comparison.curves, comparison.seeds
    return (
        panel_of("Baseline", comparison.baseline, curves[BB], baseline, seeds, points),
        panel_of("Proposed", comparison.proposed, curves[KK], proposed, seeds, points),
    )


def _drawn(values: Float, stride: int, most: int) -> Drawn:
    points = select_points(values, most)
    return Drawn((points * stride).astype(np.float64), values[points])


def step_range(panels: Sequence[CurvePanel]) -> tuple[float, float]:
    """The steps that all panels span."""
    return 0.0, float(max(panel.index.steps for panel in panels) - 1)


def reward_range(panels: Sequence[CurvePanel]) -> tuple[float, float]:
    """The range from the lowest to the highest value of all panels and 0, with some margin."""
    low = min(0.0, *(float(run.values.min()) for panel in panels for run in panel.runs))
    high = max(0.0, *(float(run.values.max()) for panel in panels for run in panel.runs))
    air = 0.04 * (high - low) or 1.0
    return low - air, high + air

"""What a panel of accumulated reward shows."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from harness.arrays import Float
from harness.eta.curve import GroupCurve, Kind
from harness.eta.index import Index
from harness.eta.scored_sums import BB, KK
from harness.report.figures.points import POINTS, select_points
from harness.results.comparison import Comparison


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


def panels_of(comparison: Comparison, points: int = POINTS) -> tuple[CurvePanel, CurvePanel] | None:
    """A panel for the baseline and one for the proposed reward; None without a finished pair."""
    indices, curves, seeds = comparison.number.decomposition, comparison.curves, comparison.seeds
    if indices is None:
        return None
    return (
        panel_of("Baseline", comparison.baseline, curves[BB], indices.baseline, seeds, points),
        panel_of("Proposed", comparison.proposed, curves[KK], indices.proposed, seeds, points),
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

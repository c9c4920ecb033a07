"""The note's regions of a mean curve, NOTE Fig. 8: Omega_1, which I_N sums, and Omega_2, which I_P sums."""

from typing import NamedTuple

import numpy as np

from harness.arrays import Float
from harness.report.figures.panel import CurvePanel

OMEGA_1, OMEGA_2 = "Ω₁", "Ω₂"
ROOM = (0.02, 0.08)
"""A region gets its name written into it if it spans at least these shares of both axes."""


class Region(NamedTuple):
    """The area between the drawn mean curve and 0."""

    name: str
    x: Float
    """Steps, (points,)."""
    y: Float
    """The curve at these steps, (points,); 0 between its parts."""

    @property
    def centre(self) -> tuple[float, float]:
        """The place for a name: half of the area lies before it, and it lies halfway between curve and 0."""
        strips = np.diff(self.x) * (self.y[1:] + self.y[:-1]) / 2.0
        done = np.cumsum(np.abs(strips))
        at = int(np.searchsorted(done, done[-1] / 2.0))
        return float(self.x[at : at + 2].mean()), float(self.y[at : at + 2].mean() / 2.0)

    def has_room(self, steps: float, height: float) -> bool:
        """Whether the region's name can be written into it, on axes of so many steps and of that height."""
        return float(np.ptp(self.x)) >= ROOM[0] * steps and float(np.ptp(self.y)) >= ROOM[1] * height


def regions_of(panel: CurvePanel) -> list[Region]:
    """Both regions of a panel's mean curve as it is drawn. A region without any area is left out."""
    steps, values = panel.mean
    is_sum = panel.kind == "accumulated"
    parts = _around_zero(steps, values) if is_sum else _around_crossover(panel, steps, values)
    found = [Region(name, *_trim(*part)) for name, part in zip((OMEGA_1, OMEGA_2), parts, strict=True)]
    return [region for region in found if len(region.x) > 1]


def _around_zero(steps: Float, values: Float) -> list[tuple[Float, Float]]:
    """The regions below 0 and above 0, with the points at which the drawn curve goes through 0."""
    before = np.flatnonzero(values[:-1] * values[1:] < 0.0)
    share = values[before] / (values[before] - values[before + 1])
    steps = np.insert(steps, before + 1, steps[before] + share * (steps[before + 1] - steps[before]))
    values = np.insert(values, before + 1, 0.0)
    return [(steps, np.minimum(values, 0.0)), (steps, np.maximum(values, 0.0))]


def _around_crossover(panel: CurvePanel, steps: Float, values: Float) -> list[tuple[Float, Float]]:
    """The regions before and after the cross-over, as indices with per-step curves are summed."""
    index = panel.index
    end = -1 if index.first_negative is None else index.steps if index.crossover is None else index.crossover
    return [(steps[side], values[side]) for side in (steps <= end, steps > end)]


def _trim(x: Float, y: Float) -> tuple[Float, Float]:
    """The points without those on 0 whose neighbours are on 0 too."""
    away = np.pad(y != 0.0, 1)
    kept = away[:-2] | away[1:-1] | away[2:]
    return x[kept], y[kept]

"""Figures of accumulated reward: what a panel shows, the points of it that are drawn, and how."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from harness.arrays import Float
from harness.eta.curve import GroupCurve, Kind
from harness.eta.index import Index
from harness.eta.splits import BB, KK
from harness.report.figures.chart import Area, Axis, Chart, Dots, Flag, Line, Word, linear_axis
from harness.results.comparison import Comparison

POINTS = 240
"""The most points that are drawn per curve, one for every second pixel. All steps of all runs would be 100 MB."""

ON_A_PAGE = 80_000
"""The most points of all single runs on a page together, which is about 0.9 MB."""
FEWEST = 40
"""The fewest points of one run: its shape can still be seen."""


def points_of_a_run(runs: int) -> int:
    """How many points a run is drawn with on a page that has so many runs."""
    return max(FEWEST, min(POINTS, ON_A_PAGE // max(1, runs)))


def select_points(values: Float, points: int = POINTS) -> NDArray[np.int64]:
    """Which steps to draw: the first, the last, and the extremes of each stretch between, in order, (<= points,).

    Every stretch keeps its lowest and its highest value, so the drawn curve reaches as far as the real one and crosses
    zero in the same stretches. Averages or every n-th step would not.
    """
    count = len(values)
    if count <= points:
        return np.arange(count)
    stretches = np.array_split(np.arange(count), points // 2 - 1)
    extremes = [stretch[pick(values[stretch])] for stretch in stretches for pick in (np.argmin, np.argmax)]
    return np.unique([0, *extremes, count - 1])


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


def draw_both(panels: tuple[CurvePanel, CurvePanel]) -> tuple[Chart, Chart]:
    """A chart for the baseline and one for the proposed reward, on equal axes: a narrow screen stacks them."""
    steps = linear_axis(*step_range(panels), "environment step", 5)
    rewards = linear_axis(*reward_range(panels), "accumulated reward")
    return _draw_panel(panels[0], steps, rewards), _draw_panel(panels[1], steps, rewards)


def _draw_panel(panel: CurvePanel, steps: Axis, rewards: Axis) -> Chart:
    colour = panel.role.lower()
    thin = [
        Line(run.steps.tolist(), run.values.tolist(), colour, f"seed {seed}", width=1.0, opacity=0.5)
        for run, seed in zip(panel.runs, panel.seeds, strict=True)
    ]
    regions = regions_of(panel)
    shades = [_shade(region, colour) for region in regions]
    thick = Line(panel.mean.steps.tolist(), panel.mean.values.tolist(), colour, "mean", width=3.0)
    flags = [Flag(step, f"{name}: step {step:,}", int(name == "first negative")) for name, step in panel.marks.items()]
    names = [Word(*it.centre, it.name) for it in regions if it.has_room(steps.high, rewards.high - rewards.low)]
    return Chart(steps, rewards, (*shades, *flags, *thin, thick, *names, _markers(panel, colour)))


def draw_curve(values: Float, stride: int, name: str, colour: str) -> Line:
    """A line through every `stride`-th step's value, of which some are drawn."""
    points = select_points(values)
    return Line((points * stride).tolist(), values[points].tolist(), colour, name)


def _shade(region: Region, colour: str) -> Area:
    """The area of a region, under the curves, down or up to 0."""
    steps, values = region.x.tolist(), region.y.tolist()
    return Area([*steps, steps[-1], steps[0]], [*values, 0.0, 0.0], colour)


def _markers(panel: CurvePanel, colour: str) -> Dots:
    """A dot on the drawn mean curve at each marked step."""
    names = tuple(f"{name}: step {step:,}" for name, step in panel.marks.items())
    return Dots(list(panel.marks.values()), panel.heights, colour, names, is_open=True)

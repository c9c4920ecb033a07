"""The figure of the published experiment: the accumulated reward of every run, and their mean, per reward."""

from harness.arrays import Float
from harness.report.figures.chart import Area, Axis, Chart, Dots, Flag, Line, Word, linear_axis
from harness.report.figures.panel import Curved, CurvePanel, panels_of, reward_range, step_range
from harness.report.figures.points import POINTS, select_points
from harness.report.figures.regions import Region, regions_of


def draw_panels(
    comparison: Curved, points: int = POINTS, amount: str = "accumulated reward"
) -> tuple[Chart, Chart] | None:
    """A panel for the baseline and one for the proposed reward, on equal axes; None without a finished pair.

    Two charts, not one: a narrow screen stacks them.

    Args:
        comparison: What to draw.
        points: Of a single run, at most.
        amount: What the curves are.
    """
    panels = panels_of(comparison, points)
    return None if panels is None else draw_both(panels, amount)


def draw_both(panels: tuple[CurvePanel, CurvePanel], amount: str = "accumulated reward") -> tuple[Chart, Chart]:
    """The same of two panels that are there."""
    steps = linear_axis(*step_range(panels), "environment step", 5)
    rewards = linear_axis(*reward_range(panels), amount)
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


def draw_curve(values: Float, stride: int, name: str, colour: str, most: int = POINTS) -> Line:
    """A line through every `stride`-th step's value, of which `most` are drawn."""
    points = select_points(values, most)
    return Line((points * stride).tolist(), values[points].tolist(), colour, name)


def _shade(region: Region, colour: str) -> Area:
    """The area of a region, under the curves, down or up to 0."""
    steps, values = region.x.tolist(), region.y.tolist()
    return Area([*steps, steps[-1], steps[0]], [*values, 0.0, 0.0], colour)


def _markers(panel: CurvePanel, colour: str) -> Dots:
    """A dot on the drawn mean curve at each marked step."""
    names = tuple(f"{name}: step {step:,}" for name, step in panel.marks.items())
    return Dots(list(panel.marks.values()), panel.heights, colour, names, is_open=True)

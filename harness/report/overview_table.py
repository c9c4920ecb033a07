"""All comparisons of an experiment at a glance, one line each, as a terminal shows it first."""

from collections.abc import Iterator, Sequence
from itertools import groupby

from rich.console import Console, ConsoleOptions, RenderableType
from rich.console import Group as Together
from rich.text import Text

from harness.eta.behaviour_change import Change
from harness.eta.headline import Answer, count_seeds
from harness.eta.index import Ratio
from harness.report.grid_table import divide_columns, show_grid
from harness.report.rows import (
    NEAR_ZERO,
    NOTHING,
    Grid,
    advice,
    answer_text,
    count_cells,
    unfinished_cells,
)
from harness.results import Results
from harness.results.combination import Combination

HEADINGS = ("", "the robot", "success", "eta_N", "eta_P", "ruler")
STYLES = {Answer.HELPS.value.upper(): "bold green", Answer.HURTS.value.upper(): "bold red"}
"""The words say it all without a colour."""
READING = (
    "success: baseline > proposed. eta = proposed / baseline, with a 95% interval where the window has room; below 1 "
    "counts as better for eta_N, above 1 for eta_P. ruler: the part of eta_P that comes from counting the same runs "
    "otherwise; no robot moved differently for it."
)


def overview_table(results: Results, details: str) -> RenderableType:
    """What is the same in all comparisons, then a line for each; of a single one what it comes to, in sentences.

    Args:
        results: The experiment.
        details: The command that shows all that this rests on.
    """
    combinations = results.combinations
    parts: list[RenderableType] = [comparison_lines(combinations)] if combinations else []
    parts += map(Text, dict.fromkeys(mixture.text for it in combinations for mixture in it.mixtures))
    if len(combinations) == 1:
        parts += _sentences(results, combinations[0])
    parts += [Text(), Text(count_cells(results), style="bold"), *map(Text, unfinished_cells(results))]
    return Together(*parts, *([Text(f"Everything that this rests on: {details}")] if combinations else []))


def comparison_lines(combinations: Sequence[Combination]) -> RenderableType:
    """A line for each of at least one comparison, below what is the same in all, and how to read them."""
    shared = Text(shared_text(combinations), style="bold")
    return Together(shared, _Overview(combinations), Text(), Text(READING, style="dim"))


class _Overview:
    """A line per comparison, with intervals if all then still stand in one line."""

    def __init__(self, combinations: Sequence[Combination]) -> None:
        self._combinations = combinations

    def __rich_console__(self, console: Console, options: ConsoleOptions) -> Iterator[RenderableType]:
        """Called by rich, which knows how wide the terminal is."""
        grids = overview_grids(self._combinations, with_intervals=True)
        if any(len(divide_columns(grid, options.max_width)) > 1 for grid in grids):
            grids = overview_grids(self._combinations, with_intervals=False)
        for grid in grids:
            yield from show_grid(grid, STYLES)


def overview_grids(combinations: Sequence[Combination], *, with_intervals: bool) -> list[Grid]:
    """A line per comparison; where both groups and rewards vary, a grid for each group."""
    varying = _varying(combinations)
    if not varying or len({it.proposed for it in combinations}) == 1:
        names = zip(line_names(combinations), combinations, strict=True)
        rows = [_row(name, it, with_intervals) for name, it in names]
        return [Grid(HEADINGS, rows, [])]
    return [
        Grid(HEADINGS, [_row(it.names.proposed, it, with_intervals) for it in members], [], name)
        for name, members in groupby(combinations, key=lambda it: _group_name(it, varying))
    ]


def shared_text(combinations: Sequence[Combination], *, with_seeds: bool = True) -> str:
    """What is the same in all of at least one, said once."""
    varying = _varying(combinations)
    told = [label for kind, label in combinations[0].group.labels.items() if kind not in varying]
    rewards, baselines = ({getattr(it, name) for it in combinations} for name in ("proposed", "baseline"))
    if varying and len(rewards) == 1:
        told += rewards
    told += [f"against {baseline}" for baseline in baselines]
    if "steps" not in varying:
        told.append(f"{combinations[0].group.steps:,} steps")
    seeds = {it.seeds for it in combinations} if with_seeds else set()
    return " · ".join([*told, *(count_seeds(len(them)) for them in seeds)] if len(seeds) == 1 else told)


def line_names(combinations: Sequence[Combination]) -> list[str]:
    """What tells each from the others: what differs between the groups, and the reward where they are several."""
    varying, rewards = _varying(combinations), {it.proposed for it in combinations}
    with_reward = not varying or len(rewards) > 1
    return [
        " · ".join([*([_group_name(it, varying)] if varying else []), *([it.names.proposed] if with_reward else [])])
        for it in combinations
    ]


def _varying(combinations: Sequence[Combination]) -> list[str]:
    """Kinds of labels that differ between groups, and ``steps`` where the trainings are not equally long."""
    kinds = [kind for kind in combinations[0].group.labels if len({it.group.labels[kind] for it in combinations}) > 1]
    return [*kinds, *(["steps"] if len({it.group.steps for it in combinations}) > 1 else [])]


def _group_name(combination: Combination, varying: Sequence[str]) -> str:
    told = {**combination.group.labels, "steps": f"{combination.group.steps:,} steps"}
    return " · ".join(told[kind] for kind in varying)


def _row(name: str, combination: Combination, with_intervals: bool) -> tuple[str, ...]:
    splits = combination.splits
    etas = (splits["eta_N"].eta, splits["eta_P"].eta)
    return (
        name,
        answer_text(combination.headline),
        success_text(combination.success),
        *(short_value(eta) + (_interval(eta) if with_intervals else "") for eta in etas),
        short_value(splits["eta_P"].ruler),
    )


def success_text(change: Change | None) -> str:
    """Both rates as whole percentages."""
    if change is None or change.baseline is None or change.proposed is None:
        return NOTHING
    return f"{100 * change.baseline:.0f}>{100 * change.proposed:.0f}%"


def short_value(ratio: Ratio) -> str:
    """Three digits of it."""
    if ratio.near_zero is not None or ratio.value is None:
        return NEAR_ZERO if ratio.near_zero is not None else NOTHING
    return _digits(ratio.value, 3)


def _interval(ratio: Ratio) -> str:
    """Two digits of each end; empty where there is none to show."""
    if ratio.near_zero is not None or ratio.low is None or ratio.high is None:
        return ""
    return f" [{_short(ratio.low)}, {_short(ratio.high)}]"


def _short(end: float) -> str:
    """Two digits, without the zero before a point."""
    text = _digits(end, 2)
    return text.replace("0.", ".", 1) if text.startswith(("0.", "-0.")) else text


def _digits(value: float, count: int) -> str:
    """So many significant digits, trailing zeros included; an exponent from a million on."""
    text = f"{value:#.{count}g}".rstrip(".")
    return f"{value:.0f}" if "e" in text and 1.0 <= abs(value) < 1e6 else text


def _sentences(results: Results, combination: Combination) -> list[RenderableType]:
    """Both answers, and how to get one where there is none."""
    headline = combination.headline
    lines = [headline.robot, headline.number, advice(results, combination)]
    return [part for line in lines if line for part in (Text(), Text(line))]

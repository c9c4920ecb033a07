"""Two rewards beside one another, and what behaviour earned under them, as a terminal shows it."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

from rich import box
from rich.table import Table
from rich.text import Text

from harness.audit.number import number
from harness.audit.recorded.earned import Earned, best_paid
from harness.audit.recorded.pair import Pair
from harness.eta.seed_mean import SeedMean

if TYPE_CHECKING:
    from harness.audit.recorded.step_apart import StepApart

MISSING = "n/a"
STEPS = "of what both pay for the same steps"
RETURNS = "of the returns of the same episodes"


def pair_grid(pair: Pair) -> Table:
    """What is asked, the answer, and what it means."""
    grid = answer_grid()
    for question, mean, meaning, why in (
        ("distance by steps", pair.steps, STEPS, "one of the two pays every step the same"),
        ("distance by episodes", pair.returns, RETURNS, "one of the two pays every episode the same, or there is one"),
    ):
        add_answer(grid, question, distance_text(mean), why if mean.mean is None else told_in(mean, pair, meaning))
    meaning = "there are no two episodes that both tell apart"
    if pair.discordant.mean is not None and pair.told_apart.mean is not None:
        told = f"of the pairs of episodes that both tell apart; these are {pair.told_apart.mean:.0%} of all pairs"
        meaning = told_in(pair.discordant, pair, told)
    add_answer(grid, "opposite order", share_text(pair.discordant), meaning)
    return grid


def told_in(mean: SeedMean, pair: Pair, meaning: str) -> str:
    """What a number means, and in how many recordings or measurements it is defined if not in all."""
    return meaning if mean.seeds == len(pair.each) else f"{meaning}; defined in {mean.seeds} of {len(pair.each)}"


def pair_lines(pair: Pair) -> list[str]:
    """A line if one is the other but for its scale, and a line for each step that is paid most differently."""
    same = [] if pair.rescaling is None else [f"{pair.rescaling.sentence(pair.other, pair.one)}."]
    return [*same, *(f"Paid most differently: {_step_text(pair, step)}." for step in pair.largest)]


def answer_grid() -> Table:
    """Three columns without headings."""
    grid = Table(box=None, show_header=False, pad_edge=False)
    grid.add_column(overflow="fold")
    grid.add_column(no_wrap=True)
    grid.add_column(overflow="fold")
    return grid


def add_answer(grid: Table, question: str, answer: str, meaning: str) -> None:
    """A row; nothing in it is markup."""
    grid.add_row(Text(question), Text(answer), Text(meaning))


def distance_text(mean: SeedMean) -> str:
    """A distance, with its interval, as text."""
    if mean.mean is None:
        return MISSING
    return f"{mean.mean:.3f}" if mean.low is None else f"{mean.mean:.3f} [{mean.low:.3f}, {mean.high:.3f}]"


def share_text(mean: SeedMean) -> str:
    """A share, with its interval, as text."""
    if mean.mean is None:
        return MISSING
    low, high = mean.low, mean.high
    return f"{mean.mean:.1%}" if low is None else f"{mean.mean:.1%} [{100.0 * low:.1f}, {100.0 * (high or 0.0):.1f}]"


def _step_text(pair: Pair, step: "StepApart") -> str:
    told = [
        f"{name} pays {number(paid)} ({abs(deviation):.1f} sd {'above' if deviation >= 0.0 else 'below'} its mean)"
        for name, paid, deviation in zip((pair.one, pair.other), step.paid, step.deviations, strict=True)
    ]
    return f"'{step.folder}', env {step.env}, episode {step.episode}, step {step.step}: {', '.join(told)}"


def earned_grid(rows: Sequence[Earned], rewards: Sequence[str]) -> Table:
    """A row for each behaviour, a column for each reward; what earned most under a reward is marked."""
    grid = Table(box=box.SIMPLE_HEAD, show_edge=False, pad_edge=False, padding=(0, 1, 0, 0))
    grid.add_column("mean return\nof an episode", overflow="fold")
    grid.add_column("episodes", justify="right")
    for name in rewards:
        grid.add_column(Text(f"paid by\n{name}"), justify="right", overflow="fold")
    best = {name: best_paid(rows, name) for name in rewards}
    for row in rows:
        values = (_earned_text(row.returns[name], row is best[name]) for name in rewards)
        grid.add_row(Text(row.behaviour), f"{row.episodes:,}", *map(Text, values))
    return grid


def _earned_text(mean: SeedMean, is_best: bool) -> str:
    if mean.mean is None:
        return MISSING
    lines = [f"{number(mean.mean)} (most)" if is_best else number(mean.mean)]
    if mean.low is not None and mean.high is not None:
        lines.append(f"[{number(mean.low)}, {number(mean.high)}]")
    return "\n".join(lines)

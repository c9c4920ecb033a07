"""Two rewards beside one another, and what behaviour earned under them, as a terminal shows it."""

from collections.abc import Callable, Sequence
from io import StringIO

from rich import box
from rich.console import Console, RenderableType
from rich.table import Table
from rich.text import Text

from harness.eta import Estimate
from harness.text import number

from ..distance import DARD, EPIC, STARC
from .earned import Earned, best_paid
from .pair import Pair, StepApart

MISSING = "n/a"
STEPS = "of what both pay for the same steps"
RETURNS = "of the returns of the same episodes"
TRANSITIONS = {
    EPIC: "without potential shaping, beside steps to any state that was met",
    DARD: "without potential shaping, beside steps near in time",
    STARC: "without potential shaping, less the value of steps near in time",
}
"""What the distances by canonical form say."""
SCALE = "Distances: 0 the same but for scale and offset, 0.71 unrelated, 1 opposite."
MOST_MEASURES = 3
"""So many measures of behaviour are shown; JSON has all."""


def pair_grid(pair: Pair) -> Table:
    """What is asked of two rewards, the answer, and what it means."""
    grid = answer_grid()
    for question, mean, meaning, why in (
        ("distance by steps", pair.steps, STEPS, "one of the two pays every step the same, or no steps were kept"),
        ("distance by episodes", pair.returns, RETURNS, "one of the two pays every episode the same, or there is one"),
    ):
        add_answer(grid, question, distance_text(mean), why if mean.value is None else told_in(mean, pair, meaning))
    meaning = "there are no two episodes that both tell apart"
    if pair.discordant.value is not None and pair.told_apart.value is not None:
        told = f"of the pairs of episodes that both tell apart; these are {pair.told_apart.value:.0%} of all pairs"
        meaning = told_in(pair.discordant, pair, told)
    add_answer(grid, "opposite order", share_text(pair.discordant), meaning)
    reasons = set(pair.reasons.values())
    if pair.forms and len(pair.reasons) == len(pair.forms) and len(reasons) == 1:
        add_answer(grid, ", ".join(pair.forms), MISSING, reasons.pop())
        return grid
    for form, distance in pair.forms.items():
        meaning = told_in(distance, pair, TRANSITIONS[form])
        add_answer(grid, f"{form} distance", distance_text(distance), pair.reasons.get(form, meaning))
    return grid


def told_in(mean: Estimate, pair: Pair, meaning: str) -> str:
    """What a number means, and in how many recordings or measurements it is defined if not in all."""
    return meaning if mean.seeds == len(pair.each) else f"{meaning}; defined in {mean.seeds} of {len(pair.each)}"


def pair_lines(pair: Pair) -> list[str]:
    """A line if one is the other but for its scale, and a line for each step that is paid most differently."""
    same = [] if pair.rescaling is None else [f"{pair.rescaling.sentence(pair.other, pair.one)}."]
    return [*same, *(f"Paid most differently: {_step_text(pair, step)}." for step in pair.largest)]


def as_text(table: RenderableType) -> str:
    """A table as text, 100 columns wide."""
    text = StringIO()
    Console(file=text, width=100, color_system=None).print(table)
    return "\n".join(line.rstrip() for line in text.getvalue().rstrip().splitlines())


def plain_grid() -> Table:
    """A table with headings, narrow, with a line below these alone."""
    return Table(box=box.SIMPLE_HEAD, show_edge=False, pad_edge=False, padding=(0, 1, 0, 0))


def answer_grid() -> Table:
    """Three columns without headings."""
    grid = Table(box=None, show_header=False, pad_edge=False)
    for is_answer in (False, True, False):
        grid.add_column(no_wrap=is_answer, overflow="ellipsis" if is_answer else "fold")
    return grid


def add_answer(grid: Table, question: str, answer: str, meaning: str) -> None:
    """A row; nothing in it is markup."""
    grid.add_row(Text(question), Text(answer), Text(meaning))


def distance_text(mean: Estimate) -> str:
    """A distance, with its interval, as text."""
    return _written(mean, "{:.3f}".format)


def share_text(mean: Estimate) -> str:
    """A share, with its interval, as text."""
    return _written(mean, "{:.1%}".format)


def _written(mean: Estimate, text: Callable[[float], str]) -> str:
    if mean.value is None:
        return MISSING
    ends = f" [{text(mean.low)}, {text(mean.high)}]" if mean.low is not None and mean.high is not None else ""
    return f"{text(mean.value)}{ends}"


def _step_text(pair: Pair, step: StepApart) -> str:
    told = [
        f"{name} pays {number(paid)} ({abs(deviation):.1f} sd {'above' if deviation >= 0.0 else 'below'} its mean)"
        for name, paid, deviation in zip((pair.one, pair.other), step.paid, step.deviations, strict=True)
    ]
    return f"'{step.folder}', env {step.env}, episode {step.episode}, step {step.step}: {', '.join(told)}"


def earned_grid(rows: Sequence[Earned], rewards: Sequence[str]) -> Table:
    """A row for each behaviour: what it was like, and what it earned. What earned most under a reward is marked."""
    grid = plain_grid()
    grid.add_column("mean\nof an episode", overflow="fold")
    grid.add_column("episodes", justify="right")
    measures = list(dict.fromkeys(name for row in rows for name in row.measures))[:MOST_MEASURES]
    for name in measures:
        grid.add_column(Text(name.replace("_", "_\n")), justify="right", overflow="fold")
    for name in rewards:
        grid.add_column(Text(f"paid by\n{name}"), justify="right", overflow="fold")
    best = {name: best_paid(rows, name) if len(rows) > 1 else None for name in rewards}
    for row in rows:
        showed = (_mean_text(row.measures.get(name)) for name in measures)
        earned = (_mean_text(row.returns[name], " (most)" * (row is best[name])) for name in rewards)
        grid.add_row(Text(row.behaviour), f"{row.episodes:,}", *map(Text, (*showed, *earned)))
    return grid


def _mean_text(mean: Estimate | None, mark: str = "") -> str:
    value, *ends = _written(mean or Estimate(None), number).partition(" ")
    return f"{value}{mark}\n{ends[-1]}".rstrip()

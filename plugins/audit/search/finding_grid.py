"""What a search found, as a terminal shows it: the three behaviours of one start, and the answer."""

from collections.abc import Iterator

from rich.console import RenderableType
from rich.table import Table
from rich.text import Text

from harness.text import number

from ..recorded.pair_grid import plain_grid
from .disturb import NOISES
from .finding import NAMES, Finding

MOST_MEASURES = 2
"""So many measures are shown; JSON has all."""


def finding_parts(finding: Finding) -> Iterator[RenderableType]:
    """The table and the answer of one reward; the word stands first in it."""
    yield Text(f"What a cheat would do for {finding.reward}", style="bold")
    yield Text()
    if finding.three:
        start = next(iter(finding.three.values())).start
        where = "the means of policies" if finding.searched.rates else f"from start {start}"
        yield Text(f"What is paid most for failing and for succeeding, {where}:\n")
        yield from (_grid(finding), Text())
    first, *others = finding.lines
    word = f"{finding.word}, {finding.strength}" if finding.strength else finding.word
    yield Text.assemble((f"{word}.", "bold"), f" {first}")
    yield from map(Text, others)
    yield Text()


def _grid(finding: Finding) -> Table:
    measures = list(dict.fromkeys(name for of in finding.three.values() for name in of.measures))[:MOST_MEASURES]
    grid = plain_grid()
    grid.add_column("behaviour", no_wrap=True)
    noises = [f"noise\n{noise:g}" for noise in NOISES]
    for heading in ("pay", f"pay\n@ {finding.gamma:g}", "steps", "success\nat step", *noises):
        grid.add_column(Text(heading), justify="right", no_wrap=True)
    for name in measures:
        grid.add_column(Text(name), justify="right", overflow="fold")
    paid = {(of.role, of.noise): of.paid for of in finding.noise}
    for role, of in finding.three.items():
        grid.add_row(
            Text(NAMES[role].removeprefix("best-paid ")),
            *map(number, (of.paid, of.discounted)),
            str(of.steps),
            str(of.time) if of.success else "never",
            *(number(paid[role, noise]) if (role, noise) in paid else "" for noise in NOISES),
            *(number(of.measures[name]) if name in of.measures else "" for name in measures),
        )
    return grid

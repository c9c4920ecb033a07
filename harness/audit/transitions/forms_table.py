"""What `harness.audit_rewards` found, as a terminal shows it."""

from io import StringIO
from typing import TYPE_CHECKING

from rich.console import Console, Group, RenderableType
from rich.text import Text

from harness.audit.recorded.pair_grid import (
    MISSING,
    add_answer,
    distance_text,
    earned_grid,
    pair_grid,
    pair_lines,
    told_in,
)
from harness.audit.transitions.form_distances import DARD, EPIC, STARC

if TYPE_CHECKING:
    from harness.audit.transitions.audit_rewards import FormsOfPair, RewardAudit

WIDTH = 100
MEANING = {
    EPIC: "without potential shaping, beside steps to any state that was met",
    DARD: "without potential shaping, beside steps near in time",
    STARC: "without potential shaping, less the value of steps near in time",
}
SCALE = "Distances: 0 the same but for scale, 0.71 unrelated, 1 opposite. Offsets do not count either."


def forms_text(audit: "RewardAudit") -> str:
    """The table as text, 100 columns wide."""
    text = StringIO()
    Console(file=text, width=WIDTH, color_system=None).print(_table(audit))
    return "\n".join(line.rstrip() for line in text.getvalue().rstrip().splitlines())


def _table(audit: "RewardAudit") -> RenderableType:
    names = ", ".join(audit.rewards)
    parts: list[RenderableType] = [Text(f"{audit.env}: rewards {names}; discount {audit.gamma:g}")]
    for it in audit.pairs:
        parts += [Text(), Text(f"{it.pair.one} and {it.pair.other}"), _grid(it), *map(Text, pair_lines(it.pair))]
    new = "1 new episode" if audit.episodes == 1 else f"{audit.episodes} new episodes"
    measured = (
        f"{SCALE} Measured {audit.measurements} times in the transitions of {', '.join(audit.policies)}, each time "
        f"with {new} of each and new samples, {audit.steps:,} steps in all. The 95% intervals "
        "are over these measurements: they say how much another measurement with the same policies would differ. Other "
        "policies meet other transitions, and there the distances are others."
    )
    earned = "Compare down a column: each reward has a scale of its own. Intervals are over episodes."
    return Group(*parts, Text(), Text(measured), Text(), earned_grid(audit.earned, audit.rewards), Text(), Text(earned))


def _grid(it: "FormsOfPair") -> RenderableType:
    grid = pair_grid(it.pair)
    reasons = set(it.reasons.values())
    if len(it.reasons) == len(it.distances) and len(reasons) == 1:
        add_answer(grid, ", ".join(it.distances), MISSING, reasons.pop())
        return grid
    for form, distance in it.distances.items():
        meaning = told_in(distance, it.pair, MEANING[form])
        add_answer(grid, f"{form} distance", distance_text(distance), it.reasons.get(form, meaning))
    return grid

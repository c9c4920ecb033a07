"""Pictures of the same episode under both rewards, drawn by the environment itself, beside one another."""

import base64
from typing import NamedTuple

from harness.record.cell import Cell
from harness.results import Results
from harness.results.comparison import Comparison, Group


class Side(NamedTuple):
    """The episode under one reward."""

    title: str
    source: str
    """The pictures side by side, as the address of an image; empty if there are none."""
    told: str
    """What the episode came to, or why there is no picture."""
    alternative: str
    """The same for those who cannot see the pictures."""
    ended: str = ""
    """The reward, and how the episode ended."""
    pictures: int = 0
    """How many pictures there are."""


class Strips(NamedTuple):
    """Both sides."""

    title: str
    sides: tuple[Side, ...]


def frames_of(results: Results, comparison: Comparison) -> Strips | None:
    """The pictures of a comparison's first seed; None for the null control, and where an arm has a replay."""
    if not comparison.seeds or comparison.is_control:
        return None
    seed = comparison.seeds[0]
    cells = {it.reward.label: it for it in results.done_cells if it.seed == seed and Group.of(it) == comparison.group}
    rewards = {"Baseline": comparison.baseline, "Proposed": comparison.proposed}
    if any(reward not in cells for reward in rewards.values()):
        return None
    sides = [_side(results, cells[reward], who, reward) for who, reward in rewards.items()]
    found = tuple(side for side in sides if side is not None)
    return Strips(f"The first episode of the evaluation of seed {seed}, in pictures", found) if found else None


def _side(results: Results, cell: Cell, who: str, reward: str) -> Side | None:
    found, title = results.frames(cell), f"{who}: {reward}"
    if found is None:
        return None
    if found.reason:
        return Side(title, "", f"No pictures: {found.reason}.", "")
    source = f"data:image/webp;base64,{base64.b64encode(found.strip).decode()}"
    told = f"{found.outcome}; {found.told}; {found.steps[-1]:,} steps"
    steps = ", ".join(f"{step:,}" for step in found.steps)
    seen, ended = f"{told}. Pictures after {steps} steps.", f"{reward}: {found.outcome}"
    return Side(title, source, seen, f"{title}: {told}", ended, len(found.steps))

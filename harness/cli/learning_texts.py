"""What a training has learned so far, in words: for the line of a running cell, and for ``harness status``."""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from harness.record.cell import Cell  # a help reads no cell, and needs no numpy

UNENDED_AFTER = 10_000
"""Environment steps without the end of an episode after which that is said; or all steps of a shorter training."""


def learned_texts(success: float | None, mean: float | None) -> list[str]:
    """The share of episodes that reached the target and what they were paid, as far as they are known."""
    return [text for text in (success_text(success), return_text(mean)) if text]


def success_text(success: float | None) -> str:
    """The share of successes as text, ``success 64 %``; empty before an episode has ended."""
    return "" if success is None else f"success {100 * success:.0f} %"


def return_text(mean: float | None) -> str:
    """The mean return as text, ``return 31.2``, with up to eight characters; empty before an episode has ended."""
    if mean is None:
        return ""
    return f"return {mean:,.0f}" if 1e3 <= abs(mean) < 1e6 else f"return {mean:.3g}"


def unended_text(cell: "Cell", steps: int, mean: float | None) -> str:
    """A line if no episode of a training has ended, where only the environment ends them; empty before that is odd.

    Args:
        cell: Which training.
        steps: How many it has done.
        mean: What its last episodes were paid; None before one has ended.
    """
    is_odd = cell.cut_after is not None and mean is None and steps >= min(UNENDED_AFTER, cell.steps)
    return f"no episode has ended in {steps:,} steps of training" if is_odd else ""

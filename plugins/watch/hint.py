"""Whether pay rises while behaviour falls, within one training."""

from collections.abc import Sequence
from dataclasses import dataclass

from harness.authoring.commands import Block


@dataclass(frozen=True)
class Hint:
    """Pay rose and behaviour fell.

    Attributes:
        text: One line.
    """

    text: str


def hint_of(blocks: Sequence[Block], lower_is_better: bool, measure: str = "success") -> Hint | None:
    """What a training's blocks hint at, or None."""
    return None

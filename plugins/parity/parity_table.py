"""A parity as a terminal shows it."""

from rich.console import Group, RenderableType
from rich.text import Text

from harness.authoring.pages import show_grid

from .grids import (
    class_grid,
    classes_text,
    contact_text,
    engines_text,
    failures,
    not_installed,
    pair_grids,
    reference_pairs,
    setting_text,
    simulator_grid,
    title,
    verdict,
)
from .parity import Parity


def parity_table(parity: Parity) -> RenderableType:
    """What ``harness parity`` prints: the pairs first, the reference's before the others'."""
    contact = contact_text(parity)
    parts: list[RenderableType] = [
        Text(title(parity), style="bold"),
        Text(f"{setting_text(parity)}\n"),
        Text(verdict(parity), style="bold"),
        *([Text(contact, style="bold")] if contact else []),
        Text(engines_text(parity)),
    ]
    for grid in (*pair_grids(parity), simulator_grid(parity)):
        parts += show_grid(grid)
    if parity.pairs:
        parts += [Text(), Text("By class of motions", style="bold"), Text(classes_text(parity))]
        parts += show_grid(class_grid(parity, reference_pairs(parity) or list(parity.pairs)))
    told = [*failures(parity), *not_installed(parity)]
    return Group(*parts, *([Text()] if told else []), *map(Text, told))

"""What a shell offers behind a flag that takes names of plugins."""

from collections.abc import Callable, Iterator
from typing import TypeAlias

from harness.text import visible

Complete: TypeAlias = Callable[[str], list[tuple[str, str]]]


def names_of(*kinds: str) -> Complete:
    """Offers the names of some kinds of plugins, after a comma too, each with its summary."""

    def complete(incomplete: str) -> list[tuple[str, str]]:
        return [offer for kind in kinds for offer in _offers(kind, incomplete)]

    return complete


def _offers(kind: str, incomplete: str) -> Iterator[tuple[str, str]]:
    from harness.registry.registry import load_registry

    before, comma, begun = incomplete.rpartition(",")
    registry = load_registry()
    for name in registry.names(kind):
        if name.startswith(begun):
            yield f"{before}{comma}{name}", visible(registry.get(kind, name).summary)

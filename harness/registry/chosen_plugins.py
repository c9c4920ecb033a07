"""Which plugins the environment variable HARNESS_PLUGINS wants, and which it does not."""

import os
from collections.abc import Collection
from dataclasses import dataclass
from typing import Self

from harness.registry.names import did_you_mean
from harness.registry.spec import OURS, canonical

VARIABLE = "HARNESS_PLUGINS"


@dataclass(frozen=True)
class Wanted:
    """What the variable says, a list with commas: names of plugins to load, and ``-name`` for plugins to leave out.

    A name is that of an entry point, ``clash``, that of a distribution, ``clash-algo``, or both, ``clash-algo/clash``.
    Where no name without a minus stands, everything else loads; where one stands, the named alone. Built-in plugins
    load unless one is left out by its name.

    Attributes:
        named: To load; None where everything is.
        left_out: Not to load.
    """

    named: frozenset[str] | None = None
    left_out: frozenset[str] = frozenset()

    @classmethod
    def from_environment(cls) -> Self:
        """What the variable of this process says; everything is wanted where it is not set."""
        value = os.environ.get(VARIABLE)
        if value is None:
            return cls()
        words = [word.strip() for word in value.split(",") if word.strip()]
        left_out = frozenset(word[1:].strip() for word in words if word.startswith("-"))
        named = frozenset(word for word in words if not word.startswith("-"))
        return cls(named if named or not left_out else None, left_out)

    def why_off(self, plugin: str, distribution: str) -> str:
        """Why a plugin is not loaded; empty if it is."""
        names = _names_of(plugin, distribution)
        if names & self.left_out:
            return f"left out by {VARIABLE}"
        if self.named is None or distribution == OURS or names & self.named:
            return ""
        return f"not named in {VARIABLE}"

    def unknown(self, plugins: Collection[tuple[str, str]]) -> list[str]:
        """A line for each name in the variable that is no plugin's.

        Args:
            plugins: Entry point and distribution of each plugin.
        """
        known = {name for plugin in plugins for name in _names_of(*plugin)}
        asked = sorted((self.named or frozenset()) | self.left_out)
        return [
            f"{VARIABLE} names '{it}', which is no plugin.{did_you_mean(it, known)}" for it in asked if it not in known
        ]


def _names_of(plugin: str, distribution: str) -> frozenset[str]:
    spellings = {distribution, canonical(distribution)}
    return frozenset({plugin, *spellings, *(f"{spelling}/{plugin}" for spelling in spellings)})

"""Folders that commands of plugins add to an experiment's: ``NAME/<cell id>/<anything>-<12 digits>/``.

Whoever registers a section of the report under a name owns the folder NAME, and the command of that name fills it.
Each of the innermost folders holds a ``manifest.json`` that tells how it ended and the digests of its other files.
"""

from pathlib import Path
from typing import Protocol

from harness.record.cell import Ending
from harness.registry.choice import Choice
from harness.registry.registry import load_registry

SECTIONS = "sections"


class Owner(Protocol):
    """The part of a `harness.results.Section` that folders are checked and copied by."""

    @property
    def what(self) -> str:
        """What one of its folders is, with an article: ``an evaluation elsewhere``."""

    def ending(self, folder: Path) -> Ending:
        """How the work for one of its folders ended, and the digests of its files.

        Raises:
            SchemaError: The manifest is damaged or written by a newer version.
        """


def owners() -> dict[str, Owner]:
    """Whoever adds folders, by name; those whose libraries are not installed left out."""
    registry = load_registry()
    there = [name for name in registry.names(SECTIONS) if not registry.get(SECTIONS, name).missing]
    return {name: Choice(name).build(registry, SECTIONS) for name in there}

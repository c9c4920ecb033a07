"""A part of the report on what a command of a plugin adds to an experiment; what its author imports."""

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

from harness.record.added import SECTIONS
from harness.record.cell import Ending
from harness.registry.choice import Choice
from harness.registry.spec import blamed_on

if TYPE_CHECKING:
    from rich.console import RenderableType

    from harness.results import Results

__all__ = ["Section", "Shown"]


class Shown(Protocol):
    """What a section says of one experiment."""

    @property
    def style(self) -> str:
        """Rules of a style sheet that the section alone needs on the page; those of the page hold anyway."""

    def to_json(self) -> Mapping[str, Any]:
        """What the report as JSON says under the section's name: plain data, finite numbers only."""

    def table(self) -> "RenderableType":
        """What a terminal shows, below all else."""

    def html(self) -> str:
        """What the page shows, in its part on all comparisons: elements of HTML, escaped, under a heading ``h3``."""


class Section(Protocol):
    """A frozen dataclass. The command of the same name fills the folder of that name in an experiment's folder.

    See `harness.record.added` for how such a folder is laid out: ``harness verify`` and ``harness merge`` know it then.
    """

    @property
    def what(self) -> str:
        """What one of its folders is, with an article: ``an evaluation elsewhere``."""

    def ending(self, folder: Path) -> Ending:
        """How the work for one of its folders ended, and the digests of its files.

        Raises:
            SchemaError: The manifest is damaged or written by a newer version.
        """

    def show(self, results: "Results") -> Shown | None:
        """What there is to say of an experiment; None if nothing.

        Raises:
            SchemaError: A file is damaged or written by a newer version.
        """


def shown_sections(results: "Results") -> dict[str, Shown]:
    """What the sections of all plugins have to say, by name; those whose libraries are not installed left out."""
    found: dict[str, Shown] = {}
    for name in results.registry.names(SECTIONS):
        spec = results.registry.get(SECTIONS, name)
        if spec.missing:
            continue
        section: Section = Choice(name).build(results.registry, SECTIONS)
        with blamed_on(spec, "the report was made"):
            shown = section.show(results)
        if shown is not None:
            found[name] = shown
    return found

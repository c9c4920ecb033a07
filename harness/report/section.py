"""What a report says, as facts, and the part of it that a command of a plugin adds."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, Protocol

from harness.errors import PluginError
from harness.record.added import SECTIONS
from harness.record.cell import Ending
from harness.registry.spec import blamed_on

if TYPE_CHECKING:
    from harness.results import Results


@dataclass(frozen=True)
class Grid:
    """A small table, ready to print: a name in the first column, then values; notes below.

    Attributes:
        headings: One for each column.
        rows: As long as `headings`. A name that begins with a blank belongs to the row above it.
        notes: Lines below.
        title: Above the table. As the heading of the names it would wrap.
    """

    headings: tuple[str, ...]
    rows: Sequence[tuple[str, ...]]
    notes: Sequence[str]
    title: str = ""


@dataclass(frozen=True)
class Fact:
    """A part of what a report says, with a blank line before it. Terminal, page, summary and records show it.

    Attributes:
        title: Above it; of an answer the subject and the word, such as ``The robot: HELPS``.
        lines: Sentences, or lines.
        grids: Small tables, below one another.
        narrower: The same tables with less beside each value, where the window is not wide enough for `grids`: two
            ways, of which the last one is for the narrowest window; empty where there is one way.
        kind: ``reading``: how to read what stands above it. ``warning``: what to know before what stands below it.
            ``command``: a command that names a folder of this machine; what is kept, and may be read on another one,
            leaves it out.
    """

    title: str = ""
    lines: tuple[str, ...] = ()
    grids: tuple[Grid, ...] = ()
    narrower: tuple[tuple[Grid, ...], ...] = ()
    kind: Literal["", "reading", "warning", "command"] = ""


@dataclass(frozen=True)
class Shown:
    """What a section says of one experiment.

    Attributes:
        facts: What stands below all else.
        data: What the report as JSON says under the section's name: plain data, finite numbers only.
        html: A picture that the page has below the facts, with its own style: elements of HTML, escaped.
    """

    facts: tuple[Fact, ...]
    data: Mapping[str, Any]
    html: str = ""


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
        with blamed_on(spec, "the report was made"):
            section: Section = spec.load()()
            shown = section.show(results)
        if not isinstance(shown, Shown | None):
            raise PluginError(f"{spec.title} shows a {type(shown).__name__}; write harness.results.Shown(facts, data)")
        if shown is not None:
            found[name] = shown
    return found

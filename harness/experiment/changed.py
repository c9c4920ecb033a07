"""Finds done cells that were made by other plugins than those installed now, so that they are not mixed unnoticed."""

from collections.abc import Iterator, Mapping, Sequence
from functools import cache
from typing import TYPE_CHECKING, Literal, NamedTuple, TypeAlias

from harness.errors import UsageError
from harness.experiment.provenance import function_digests, robot_digest
from harness.hookspecs import KINDS
from harness.record.cell import SHOWN_DIGITS, Cell
from harness.registry.choice import Registry
from harness.registry.sources import source_hash

if TYPE_CHECKING:
    from harness.robot import Robot

Changed: TypeAlias = Literal["refuse", "keep", "again"]
"""What happens to such cells: the run is refused, or they are kept beside new ones, or they are done again."""
CHANGED: tuple[Changed, ...] = ("refuse", "keep", "again")
Sources: TypeAlias = Mapping[str, str]
"""SHA-256 of the files of each plugin that made a cell, by kind, and of its functions; see `describe_environment`."""
REMEDY = (
    "--changed keep keeps these cells, and reports say so; --changed again trains them again; "
    "another --out leaves them alone"
)
GONE = "none"
"""In place of a hash, if a file with functions is not given any more."""
NAMED = 2
"""The most plugins that the message names, so that it has room to say what to do."""


class Change(NamedTuple):
    """A plugin whose source files are not those that made a done cell."""

    name: str
    """The name of the plugin, or the path of a robot's files."""
    then: str
    """SHA-256 of the files that made the cell."""
    now: str
    """SHA-256 of the files that are installed."""

    @property
    def text(self) -> str:
        """The plugin and both hashes, cut short."""
        return f"{self.name} ({self.then[:SHOWN_DIGITS]}, now {self.now[:SHOWN_DIGITS]})"


def changed_cells(done: Mapping[Cell, Sources], registry: Registry) -> dict[Cell, tuple[Change, ...]]:
    """The done cells that were made by other plugins than those installed now, each with what changed.

    Args:
        done: Cells with the hashes that their manifests tell.
        registry: The plugins.

    Raises:
        UsageError: A plugin is not installed, or a robot is not there.
    """

    @cache
    def robot(name: str) -> "Robot":
        from harness.robot.robot import load_robot  # here, since an environment has none

        return load_robot(name, registry)

    @cache
    def source(kind: str, name: str) -> str:
        return source_hash(registry.get(kind, name).load())

    def changes(cell: Cell, recorded: Sources) -> Iterator[Change]:
        """The plugins that made a cell and have changed since. A plugin without a recorded hash is left out."""
        for kind, name in cell.plugins.items():
            if kind in recorded:
                now = robot_digest(cell, robot(name)) if kind == "robots" else source(kind, name)
                yield Change(name, recorded[kind], now)
        functions = function_digests(cell, registry)
        for name in (name for name in recorded if name not in KINDS):
            yield Change(name, recorded[name], functions.get(name, GONE))

    found = {cell: tuple(it for it in changes(cell, told) if it.then != it.now) for cell, told in done.items()}
    return {cell: of_cell for cell, of_cell in found.items() if of_cell}


def refuse_changed(changed: Mapping[Cell, Sequence[Change]], remedy: str = REMEDY) -> None:
    """Check that there is no such cell.

    Args:
        changed: See `changed_cells`.
        remedy: What to do.

    Raises:
        UsageError: There is one; names the plugins, and what can be chosen.
    """
    if not changed:
        return
    noun = "done cell was" if len(changed) == 1 else "done cells were"
    changes = list(dict.fromkeys(change for of_cell in changed.values() for change in of_cell))
    named = ", ".join(change.text for change in changes[:NAMED])
    more = f" and {len(changes) - NAMED} more" if len(changes) > NAMED else ""
    raise UsageError(f"{len(changed)} {noun} made by another {named}{more}: {remedy}")

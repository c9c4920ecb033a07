"""What a line of ``harness audit`` asks, and what whatever audits its subject answers."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, TypeAlias

if TYPE_CHECKING:
    from harness.registry import Registry

    from .audit import Audit
    from .dataset.dataset_audit import DatasetAudit
    from .search.find import Search
    from .search.place import Place


@dataclass(frozen=True, kw_only=True)
class Asked:
    """A line; see the flags. What it does not say is None, or empty.

    Attributes:
        registry: The plugins.
        named: What is audited.
        search: How much is searched; None for nothing.
    """

    registry: "Registry"
    named: str
    rewards: Sequence[str]
    robot: str | None
    sim: str | None
    against: str | None
    episodes: int | None
    gamma: float | None
    search: "Search | None"
    random: Path | None
    log_format: str
    sort: str
    leave_out: tuple[Path, ...]
    places: str | None
    success: str
    labels: Path | None
    success_above: float | None
    cluster: str
    partial: bool
    beginner: str | None

    @property
    def folder(self) -> Path:
        """What is audited, as a path."""
        return Path(self.named)


Answered: TypeAlias = "tuple[Sequence[Audit | DatasetAudit], Sequence[Place]]"
"""An audit of each reward of a task, of everything else one; and where what a cheat would do may be searched, a place
for each reward."""

"""The time that an experiment took."""

from collections.abc import Iterable
from datetime import datetime, timedelta
from typing import NamedTuple

from harness.authoring.commands import Manifest


class Effort(NamedTuple):
    """The time that the cells took that ran, finished or not."""

    cells: int
    seconds: float
    """The sum over all cells, [s]. Cells may run at the same time."""
    first: datetime | None
    """When the first cell began; None if none ran."""
    last: datetime | None
    """When the last one ended."""

    @property
    def span(self) -> float | None:
        """The time from the first beginning to the last end, [s], pauses included."""
        return (self.last - self.first).total_seconds() if self.first and self.last else None


def effort_of(manifests: Iterable[Manifest]) -> Effort:
    """The time that the cells took that ran."""
    ran = [manifest for manifest in manifests if manifest.status in ("done", "failed")]
    begun = [(datetime.fromisoformat(manifest.started), manifest.seconds) for manifest in ran if manifest.started]
    return Effort(
        len(ran),
        sum(manifest.seconds for manifest in ran),
        min((start for start, _ in begun), default=None),
        max((start + timedelta(seconds=seconds) for start, seconds in begun), default=None),
    )


def duration_text(seconds: float) -> str:
    """A duration as people write it: ``12.5 s``, ``25 min``, ``3 h 5 min``."""
    if seconds < 100:
        return f"{seconds:.1f} s"
    minutes = round(seconds / 60)
    return f"{minutes} min" if minutes < 100 else f"{minutes // 60} h {minutes % 60} min"

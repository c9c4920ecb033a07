"""What an experiment took."""

from collections.abc import Iterable
from datetime import datetime, timedelta
from typing import NamedTuple

from harness.record.manifest import Manifest


class Effort(NamedTuple):
    """Of the cells that ran, finished or not."""

    cells: int
    seconds: float
    """Of all cells together, [s]; cells run beside one another."""
    first: datetime | None
    """When the first cell began; None if none ran."""
    last: datetime | None
    """When the last one ended."""

    @property
    def span(self) -> float | None:
        """From the one to the other, [s], pauses included."""
        return (self.last - self.first).total_seconds() if self.first and self.last else None


def effort_of(manifests: Iterable[Manifest]) -> Effort:
    """What the cells that ran took."""
    ran = [manifest for manifest in manifests if manifest.status in ("done", "failed")]
    begun = [(datetime.fromisoformat(manifest.started), manifest.seconds) for manifest in ran if manifest.started]
    return Effort(
        len(ran),
        sum(manifest.seconds for manifest in ran),
        min((start for start, _ in begun), default=None),
        max((start + timedelta(seconds=seconds) for start, seconds in begun), default=None),
    )


def duration_text(seconds: float) -> str:
    """For people: ``12.5 s``, ``25 min``, ``3 h 5 min``."""
    if seconds < 100:
        return f"{seconds:.1f} s"
    minutes = round(seconds / 60)
    return f"{minutes} min" if minutes < 100 else f"{minutes // 60} h {minutes % 60} min"

"""When two simulators see the arm touch the ground."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from harness.arrays import Mask

GRACE = 5
"""Control periods after the first contact that still count: later ones tell how the arms bounce."""

CONTACT_KEYS = ("contact_disagreement", "dives", "mean_contact_delay_s", "max_contact_delay_s")
"""Keys of the JSON."""


@dataclass(frozen=True)
class Contact:
    """Two simulators' ground contacts in the same dives.

    Attributes:
        disagreement: Share of the samples in which one sees contact and the other does not. Samples of an episode:
            from its start to `GRACE` control periods after the first contact that either sees, or to its end.
        both: Dives in which both see contact.
        only_a: Those in which the first one alone does.
        only_b: Those in which the second one alone does.
        neither: Those that touch nothing.
        mean_delay_s: By what the second sees the first contact later than the first does, mean over `both`, [s];
            None without any.
        max_delay_s: The largest difference of the two, either way, [s]; None likewise.
    """

    disagreement: float
    both: int
    only_a: int
    only_b: int
    neither: int
    mean_delay_s: float | None
    max_delay_s: float | None

    @property
    def note(self) -> str:
        """What a reader has to know; empty where every dive touches the ground in both."""
        dives = self.both + self.only_a + self.only_b + self.neither
        found = [(self.only_a, "the first alone"), (self.only_b, "the second alone"), (self.neither, "neither")]
        told = [f"{count} in {who}" for count, who in found if count]
        return f"of {dives} dives, {', '.join(told)} touch the ground" if told else ""

    def to_json(self) -> dict[str, Any]:
        """Plain data."""
        dives = {"both": self.both, "only_a": self.only_a, "only_b": self.only_b, "neither": self.neither}
        values = (self.disagreement, dives, self.mean_delay_s, self.max_delay_s)
        return dict(zip(CONTACT_KEYS, values, strict=True))


def compare_contacts(a: Mask, b: Mask, period: float) -> Contact:
    """Ground contact of two simulators in the same dives.

    Args:
        a: Whether the first sees contact, (rows, episodes); row 0 is the start.
        b: The same of the second.
        period: From one row to the next, [s].
    """
    first_a, first_b = first_contacts(a), first_contacts(b)
    counted = np.arange(len(a))[:, None] <= np.minimum(first_a, first_b) + GRACE
    touched_a, touched_b = a.any(axis=0), b.any(axis=0)
    both = touched_a & touched_b
    delays = (first_b - first_a)[both] * period
    return Contact(
        float((a != b)[counted].mean()),
        int(both.sum()),
        int((touched_a & ~touched_b).sum()),
        int((touched_b & ~touched_a).sum()),
        int((~touched_a & ~touched_b).sum()),
        float(delays.mean()) if both.any() else None,
        float(np.abs(delays).max()) if both.any() else None,
    )


def first_contacts(contact: Mask) -> NDArray[np.intp]:
    """The first row of `contact`, (rows, episodes), that sees any, (episodes,); the number of rows without any."""
    return np.where(contact.any(axis=0), contact.argmax(axis=0), len(contact))

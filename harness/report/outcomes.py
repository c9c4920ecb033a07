"""How the episodes of the trained policies ended: at the target, on the ground, or when the time was over."""

from typing import NamedTuple

from harness.eta.headline import SUCCESS
from harness.results.combination import Combination

TIMEOUTS = "timeouts"
LEAST = 0.08
"""A share below this is too narrow for its number."""


class Part(NamedTuple):
    """One way to end."""

    kind: str
    """``reached``, ``ground`` or ``time-out``."""
    share: float
    """Of the episodes, in [0, 1]."""
    text: str
    """Written into the bar; empty where there is no room."""


class Bar(NamedTuple):
    """One reward's episodes."""

    who: str
    reward: str
    parts: tuple[Part, ...]
    told: str
    """The same in words."""


def outcome_bars(combination: Combination) -> list[Bar]:
    """A bar for the baseline, one for the proposed reward, one for random actions; empty where it was not measured."""
    changes = {change.name: change for change in combination.changes_of(combination.manner)}
    success, timeouts = changes.get(SUCCESS), changes.get(TIMEOUTS)
    if success is None or timeouts is None:
        return []
    names = combination.names
    sides = (
        ("Baseline", names.baseline, success.baseline, timeouts.baseline),
        ("Proposed", names.proposed, success.proposed, timeouts.proposed),
        ("Random", "random actions", success.random, timeouts.random),
    )
    return [
        _bar(who, reward, reached, over)
        for who, reward, reached, over in sides
        if reached is not None and over is not None
    ]


def _bar(who: str, reward: str, reached: float, over: float) -> Bar:
    """What neither reached the target nor ran out of time ended on the ground."""
    shares = {"reached": reached, "ground": max(0.0, 1.0 - reached - over), "time-out": over}
    told = ", ".join(f"{kind} {share:.1%}" for kind, share in shares.items())
    parts = (Part(kind, share, f"{share:.0%}" if share >= LEAST else "") for kind, share in shares.items())
    return Bar(who, reward, tuple(part for part in parts if part.share > 0.0), told)

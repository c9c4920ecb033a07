"""How the episodes of the trained policies ended: at the target, on the ground, at an obstacle, or out of time."""

from typing import NamedTuple

from harness.eta.headline import SUCCESS
from harness.results.comparison import Comparison

TIMEOUTS, OBSTACLES = "timeouts", "obstacle_hits"
LEAST = 0.08
"""A share below this is too narrow for its number."""


class Part(NamedTuple):
    """A part of a bar: one way in which episodes ended."""

    kind: str
    """``reached``, ``ground``, ``obstacle`` or ``time-out``."""
    share: float
    """Share of the episodes, in [0, 1]."""
    text: str
    """The text that is written into the bar; empty if there is no room."""


class Bar(NamedTuple):
    """One reward's episodes."""

    who: str
    reward: str
    parts: tuple[Part, ...]
    told: str
    """The same in words."""


def outcome_bars(comparison: Comparison) -> list[Bar]:
    """Bars for the baseline, the proposed reward and random actions; empty if the outcomes were not measured."""
    changes = {change.name: change for change in comparison.changes_of(comparison.manner)}
    success, timeouts = changes.get(SUCCESS), changes.get(TIMEOUTS)
    if success is None or timeouts is None:
        return []
    names, hits = comparison.names, changes.get(OBSTACLES)
    struck = (None, None, None) if hits is None else (hits.baseline, hits.proposed, hits.random)
    sides = (
        ("Baseline", names.baseline, success.baseline, timeouts.baseline, struck[0]),
        ("Proposed", names.proposed, success.proposed, timeouts.proposed, struck[1]),
        ("Random", "random actions", success.random, timeouts.random, struck[2]),
    )
    return [
        _bar(who, reward, reached, over, hit or 0.0)
        for who, reward, reached, over, hit in sides
        if reached is not None and over is not None
    ]


def _bar(who: str, reward: str, reached: float, over: float, hit: float) -> Bar:
    """A bar. Episodes with no target reached, no obstacle touched and time left ended on the ground."""
    shares = {"reached": reached, "ground": max(0.0, 1.0 - reached - over - hit), "time-out": over}
    if hit:
        shares["obstacle"] = hit
    told = ", ".join(f"{kind} {share:.1%}" for kind, share in shares.items())
    parts = (Part(kind, share, f"{share:.0%}" if share >= LEAST else "") for kind, share in shares.items())
    return Bar(who, reward, tuple(part for part in parts if part.share > 0.0), told)

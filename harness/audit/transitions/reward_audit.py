"""What `harness.audit_rewards` found, and how a terminal shows it."""

from collections.abc import Mapping
from dataclasses import dataclass
from io import StringIO
from typing import Any

from rich.console import Console, Group, RenderableType
from rich.text import Text

from harness.audit.recorded.earned import Earned
from harness.audit.recorded.pair import Pair, mean_json
from harness.audit.recorded.pair_grid import (
    MISSING,
    add_answer,
    distance_text,
    earned_grid,
    pair_grid,
    pair_lines,
    told_in,
)
from harness.audit.transitions.form_distances import DARD, EPIC, STARC
from harness.eta.seed_mean import SeedMean

WIDTH = 100
MEANING = {
    EPIC: "without potential shaping, beside steps to any state that was met",
    DARD: "without potential shaping, beside steps near in time",
    STARC: "without potential shaping, less the value of steps near in time",
}
SCALE = "Distances: 0 the same but for scale, 0.71 unrelated, 1 opposite. Offsets do not count either."


@dataclass(frozen=True)
class FormsOfPair:
    """Two rewards beside one another.

    Attributes:
        pair: In the steps that were taken.
        distances: By canonical form, in [0, 1]: means over the measurements. Without a value where it is not defined.
        reasons: By canonical form without a value: why.
    """

    pair: Pair
    distances: Mapping[str, SeedMean]
    reasons: Mapping[str, str]


@dataclass(frozen=True)
class RewardAudit:
    """What `audit_rewards` found; ``print`` shows it.

    Attributes:
        env: Its id.
        policies: Who acted.
        gamma: Discount per step.
        measurements: How many, each with episodes and samples of its own.
        episodes: Of each policy in a measurement.
        steps: That were taken in all.
        rewards: Names, ``own`` among them.
        pairs: Every two of them.
        earned: What each policy earned under each reward, means and intervals over all of its episodes.
    """

    env: str
    policies: tuple[str, ...]
    gamma: float
    measurements: int
    episodes: int
    steps: int
    rewards: tuple[str, ...]
    pairs: tuple[FormsOfPair, ...]
    earned: tuple[Earned, ...]

    def __str__(self) -> str:
        return _text(self)

    def to_json(self) -> dict[str, Any]:
        """Plain data, finite numbers only."""
        return {
            "env": self.env,
            "policies": list(self.policies),
            "gamma": self.gamma,
            "measurements": self.measurements,
            "episodes": self.episodes,
            "steps": self.steps,
            "rewards": list(self.rewards),
            "pairs": [
                {
                    **it.pair.to_json(),
                    **{form: mean_json(mean) for form, mean in it.distances.items()},
                    "reasons": dict(it.reasons),
                }
                for it in self.pairs
            ],
            "earned": [row.to_json() for row in self.earned],
        }


def _text(audit: RewardAudit) -> str:
    """The table as text, 100 columns wide."""
    text = StringIO()
    Console(file=text, width=WIDTH, color_system=None).print(_table(audit))
    return "\n".join(line.rstrip() for line in text.getvalue().rstrip().splitlines())


def _table(audit: RewardAudit) -> RenderableType:
    names = ", ".join(audit.rewards)
    parts: list[RenderableType] = [Text(f"{audit.env}: rewards {names}; discount {audit.gamma:g}")]
    for it in audit.pairs:
        parts += [Text(), Text(f"{it.pair.one} and {it.pair.other}"), _grid(it), *map(Text, pair_lines(it.pair))]
    new = "1 new episode" if audit.episodes == 1 else f"{audit.episodes} new episodes"
    measured = (
        f"{SCALE} Measured {audit.measurements} times in the transitions of {', '.join(audit.policies)}, each time "
        f"with {new} of each and new samples, {audit.steps:,} steps in all. The 95% intervals "
        "are over these measurements. They say how much another measurement with the same policies would differ. Other "
        "policies meet other transitions, where the distances are others."
    )
    earned = "Compare down a column: each reward has a scale of its own. Intervals are over episodes."
    return Group(*parts, Text(), Text(measured), Text(), earned_grid(audit.earned, audit.rewards), Text(), Text(earned))


def _grid(it: FormsOfPair) -> RenderableType:
    grid = pair_grid(it.pair)
    reasons = set(it.reasons.values())
    if len(it.reasons) == len(it.distances) and len(reasons) == 1:
        add_answer(grid, ", ".join(it.distances), MISSING, reasons.pop())
        return grid
    for form, distance in it.distances.items():
        meaning = told_in(distance, it.pair, MEANING[form])
        add_answer(grid, f"{form} distance", distance_text(distance), it.reasons.get(form, meaning))
    return grid

"""An audit of recordings, as a terminal shows it."""

from rich.console import Group, RenderableType
from rich.text import Text

from harness.audit.recorded.pair_grid import earned_grid, pair_grid, pair_lines
from harness.audit.recorded.recordings import RecordedAudit

SCALE = "Distances: 0 the same but for scale and offset, 0.71 unrelated, 1 opposite."
NOT_ASKED = (
    "A recording holds what rewards paid, and no observations. EPIC, DARD and STARC ask a reward about other steps, so "
    "they need the reward itself: harness.audit_rewards in Python computes them."
)
EARNED = (
    "Compare down a column: each reward has a scale of its own. Means whose intervals overlap may differ by chance. "
    "The interval of random actions is over episodes, that of trainings over trainings."
)


def recorded_table(audit: RecordedAudit) -> RenderableType:
    """What ``harness audit FOLDER`` prints."""
    noun = "evaluation" if audit.evaluations else "training"
    count = len(audit.compared)
    parts: list[RenderableType] = [
        Text(f"{audit.env}: {count} recorded {noun}{'s' * (count != 1)}, rewards {', '.join(audit.rewards)}", "bold"),
        *(Text(f"{line}.") for line in audit.notes),
    ]
    for pair in audit.pairs:
        parts += [Text(), Text(f"{pair.one} and {pair.other}", style="bold"), pair_grid(pair)]
        parts += map(Text, pair_lines(pair))
    few = "" if count >= 3 else " No intervals below three of them."
    parts += [Text(), Text(f"{SCALE} Means over {noun}s, 95% intervals over them in brackets.{few}"), Text(NOT_ASKED)]
    parts += [Text(), earned_grid(audit.earned, audit.rewards), Text()]
    return Group(*parts, Text(EARNED))

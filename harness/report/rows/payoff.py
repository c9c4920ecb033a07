"""What a reward pays for, as the page shows it: the returns of scripted policies under it.

A report reads results only. The caller asks the rewards and passes in what they pay.
"""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

from harness.eta.index import NOTHING
from harness.report.rows.ratios import Grid, format_number
from harness.results.comparison import Comparison


class Payoffs(NamedTuple):
    """What one reward pays the scripted policies of one robot and task."""

    verdict: tuple[str, ...]
    """Whether reaching the target pays best, in sentences; or why that is not known."""
    returns: Mapping[str, float]
    """Mean return of an episode, event terms included, by script; empty where it is not known."""
    success: Mapping[str, float]
    """Share of the episodes that end at the target, by script."""


Audits = Mapping[tuple[str, str, str], Payoffs]
"""By robot, label of the task and label of the reward."""

TITLE = "What the rewards pay for"
EXPLANATION = (
    "Scripted policies take the place of a learner, and their joints move exactly as commanded. The numbers say what "
    "an episode of each policy earns. A reward that pays more for something else than finishing teaches something else."
)


class Story(NamedTuple):
    """What both rewards pay for, and what the robot did under them."""

    sentences: tuple[str, ...]
    grid: Grid


def payoff_story(comparison: Comparison, audits: Audits) -> Story | None:
    """The story of a comparison; None if no audit was made."""
    group = comparison.group
    labels = list(dict.fromkeys((comparison.baseline, comparison.proposed)))
    found = {label: audits[key] for label in labels if (key := (group.robot, group.task.label, label)) in audits}
    if not found:
        return None
    sentences = [
        f"{label}: {' '.join(payoffs.verdict)}{_done(comparison, label, payoffs)}" for label, payoffs in found.items()
    ]
    return Story(tuple(sentences), _grid(found))


def _done(comparison: Comparison, label: str, payoffs: Payoffs) -> str:
    """What the robot did that was trained with this reward."""
    changes = {change.name: change for change in comparison.measured.changes_of(comparison.manner)}
    over, missed = (changes.get(name) for name in ("timeouts", "closest_distance"))
    if not payoffs.returns or over is None:
        return ""
    is_baseline = label == comparison.baseline
    share = over.baseline if is_baseline else over.proposed
    if share is None:
        return ""
    told = f" The robot that learned from it ran out of time in {share:.1%} of the episodes"
    nearest = missed and (missed.baseline if is_baseline else missed.proposed)
    near = f"; on average it came as near as {nearest:.3g} {missed.measure.unit}" if missed and nearest else ""
    return f"{told}{near}."


def _grid(found: Mapping[str, Payoffs]) -> Grid:
    """A row for each script. The script that earns most under the last reward comes first."""
    *_, last = found.values()
    scripts: Sequence[str] = sorted(last.returns, key=lambda script: -last.returns[script])
    rows = [
        (
            script,
            f"{last.success[script]:.0%}",
            *(format_number(payoffs.returns[script]) if payoffs.returns else NOTHING for payoffs in found.values()),
        )
        for script in scripts
    ]
    headings = ("scripted policy", "success", *(f"return under {label}" for label in found))
    return Grid(headings, rows, [])

"""The cells of a combination that are not done."""

from collections import Counter

from harness.authoring.commands import Comparison, Group, Status, told_manifests
from harness.results import Results

STATUSES: tuple[Status, ...] = ("failed", "skipped", "pending", "not needed", "damaged")


def missing_text(results: Results, combination: Comparison) -> str:
    """How many cells are not done, by their state: ``2 failed, 1 pending of 20 cells``; empty if all are done."""
    rewards = {combination.baseline, combination.proposed}
    statuses = Counter(
        manifest.status
        for manifest in told_manifests(results)
        if manifest.cell.reward.label in rewards
        and Group.of(manifest.cell) == combination.group
        and (combination.is_control or not results.is_control(manifest.cell))
    )
    told = [f"{statuses[status]} {status}" for status in STATUSES if statuses[status]]
    return f"{', '.join(told)} of {statuses.total()} cells" if told else ""

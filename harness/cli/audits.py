"""What the rewards of an experiment pay for, asked anew for its page: scripted policies, no engine, nothing trained."""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Sequence

    from harness.payoff.rollout import Rollout
    from harness.record.cell import Cell
    from harness.registry.registry import Registry
    from harness.report.rows.payoff import Audits, Payoffs
    from harness.results import Results

EPISODES = 20
"""The episodes of each scripted policy: half a second for a robot and task, and the answer no longer changes."""
GAMMA = 0.95
"""The discount that ``harness audit`` has too."""


def audits_of(results: "Results") -> "Audits":
    """By robot, task and reward; a reward that cannot be asked says why."""
    return pays_of([manifest.cell for manifest in results.done], results.registry)


def pays_of(cells: "Sequence[Cell]", registry: "Registry") -> "Audits":
    """The same of the rewards that cells of an arm train by; others are left out."""
    asked = {
        (cell.robot, cell.task.label, cell.reward.label): cell
        for cell in cells
        if cell.task.name in registry.names("tasks")
    }
    rollouts: dict[tuple[str, str], tuple[Rollout, ...] | str] = {}
    found: dict[tuple[str, str, str], Payoffs] = {}
    for key, cell in asked.items():
        place = key[:2]
        if place not in rollouts:
            rollouts[place] = _record(cell, registry)
        found[key] = _ask(cell, registry, rollouts[place])
    return found


def _record(cell: "Cell", registry: "Registry") -> "tuple[Rollout, ...] | str":
    """What the scripted policies do; or why they cannot."""
    from harness.env.ideal import IdealSimulator
    from harness.errors import reason_of
    from harness.payoff.rollout import record_rollouts
    from harness.robot.robot import load_robot

    try:
        task = cell.task.build(registry, "tasks")
        return record_rollouts(IdealSimulator(), load_robot(cell.robot, registry), task, EPISODES)
    except (Exception, SystemExit) as error:  # not installed, not without an engine, or whatever a plugin raises
        return reason_of(error)


def _ask(cell: "Cell", registry: "Registry", rollouts: "tuple[Rollout, ...] | str") -> "Payoffs":
    """What the cell's reward pays in these rollouts."""
    from harness.errors import reason_of
    from harness.payoff.finishing import finishing_of, on_finishing, on_terms
    from harness.payoff.score import score_rollout
    from harness.report.rows.payoff import Payoffs

    if isinstance(rollouts, str):
        return Payoffs((f"Not known: {rollouts}",), {}, {})
    try:
        reward = cell.reward.build(registry, "rewards")
        found = finishing_of([score_rollout(reward, rollout) for rollout in rollouts], GAMMA)
    except (Exception, SystemExit) as error:
        return Payoffs((f"Not known: {reason_of(error)}",), {}, {})
    return Payoffs(
        (on_finishing(found), *on_terms(found)),
        {payoff.policy: payoff.total for payoff in found.payoffs},
        {payoff.policy: payoff.success for payoff in found.payoffs},
    )

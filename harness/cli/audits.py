"""What the rewards of an experiment pay for, asked anew for its page: scripted policies, no engine, nothing trained."""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from harness.payoff.finishing import UnderNoise
    from harness.payoff.rollout import Rollout
    from harness.record.cell import Cell
    from harness.registry.registry import Registry
    from harness.report.rows.payoff import Audits, Payoffs
    from harness.results import Results

EPISODES = 20
"""The episodes of each scripted policy: half a second for a robot and task, and the answer no longer changes."""
GAMMA = 0.95
"""The discount that ``harness audit`` has too."""
NOISE = 0.05
"""The noise on every action that ``harness audit`` tries too."""


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
    rollouts: dict[tuple[str, str, float], tuple[Rollout, ...] | str] = {}

    def record(cell: "Cell", noise: float) -> "tuple[Rollout, ...] | str":
        place = (cell.robot, cell.task.label, noise)
        if place not in rollouts:
            rollouts[place] = _record(cell, registry, noise)
        return rollouts[place]

    return {key: _ask(cell, registry, record) for key, cell in asked.items()}


def _record(cell: "Cell", registry: "Registry", noise: float) -> "tuple[Rollout, ...] | str":
    """What the scripted policies do; or why they cannot."""
    from harness.env.ideal import IdealSimulator
    from harness.errors import reason_of
    from harness.payoff.rollout import record_rollouts
    from harness.robot.robot import load_robot

    try:
        task = cell.task.build(registry, "tasks")
        return record_rollouts(IdealSimulator(), load_robot(cell.robot, registry), task, EPISODES, noise)
    except (Exception, SystemExit) as error:  # not installed, not without an engine, or whatever a plugin raises
        return reason_of(error)


def _ask(cell: "Cell", registry: "Registry", record: "Callable[[Cell, float], tuple[Rollout, ...] | str]") -> "Payoffs":
    """What the cell's reward pays in these rollouts."""
    from harness.errors import reason_of
    from harness.payoff.finishing import finishing_of, on_finishing, on_terms, under_noise
    from harness.payoff.score import score_rollout
    from harness.report.rows.payoff import Payoffs

    rollouts = record(cell, 0.0)
    if isinstance(rollouts, str):
        return Payoffs((f"Not known: {rollouts}",), {}, {})
    try:
        reward = cell.reward.build(registry, "rewards")
        found = finishing_of([score_rollout(reward, rollout) for rollout in rollouts], GAMMA)
        noisy = record(cell, NOISE) if found.undiscounted or found.discounted else ""
        disturbed = [score_rollout(reward, rollout) for rollout in noisy if not isinstance(rollout, str)]
        reason = _on_noise(under_noise(found, finishing_of(disturbed, GAMMA))) if disturbed else ""
    except (Exception, SystemExit) as error:
        return Payoffs((f"Not known: {reason_of(error)}",), {}, {})
    return Payoffs(
        (on_finishing(found), *filter(None, [reason]), *on_terms(found)),
        {payoff.policy: payoff.total for payoff in found.payoffs},
        {payoff.policy: payoff.success for payoff in found.payoffs},
    )


def _on_noise(noisy: "UnderNoise") -> str:
    """Why a learner finishes all the same, or may not."""
    from harness.text import number

    pay = f"{noisy.policy} earns {number(noisy.earns)}, finish {number(noisy.finish_earns)}"
    if noisy.is_robust:
        return f"A learner may well find that: with noise on its actions ({NOISE:g}) {pay}."
    return (
        f"A learner may finish all the same, for the behaviour is fragile: with noise on its actions ({NOISE:g}), as "
        f"while it explores, {pay}."
    )

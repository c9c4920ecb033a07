"""A reward on the scripted movements of an arm: everything is asked of it. Trains nothing."""

from collections.abc import Mapping, Sequence

import numpy as np

from harness.audit.audit import Audit, OfScripts
from harness.audit.canonical import forms_of_distances
from harness.audit.distance import compare_forms
from harness.audit.probe import needed_beside_distances
from harness.audit.properties import properties_of, workspace_ratios
from harness.audit.questions import finishing_of
from harness.audit.recorded.earned import earned_in_episodes
from harness.audit.recorded.paid import Paid, compare_paid
from harness.audit.recorded.pair import pair_of
from harness.audit.recorded.pair_grid import SCALE
from harness.audit.rollout import Rollout
from harness.audit.score import Score, score_rollout
from harness.audit.transitions.rollout_forms import COMPARED, forms_of_rollouts
from harness.audit.verdict import verdict_of
from harness.eta.rescaling import Line, line_of
from harness.results.recordings.episodes import Episodes
from harness.results.recordings.runs import SUCCESS
from harness.reward import Reward

STEPS = "steps"
RECORDED = (
    "These distances were computed from recorded transitions, because a reward reads {}, and not distances alone: each "
    "was asked what a recorded action pays between two recorded states."
)
TRIED = 64
"""So many episodes of each script are enough to try properties on."""


def audit_reward(
    reward: Reward,
    against: Reward,
    rollouts: Sequence[Rollout],
    gamma: float,
    names: tuple[str, str] = ("reward", "against"),
    setting: str = "",
) -> Audit:
    """What `reward` pays for in the rollouts of the scripted policies.

    Args:
        reward: The reward.
        against: The one that it is compared with.
        rollouts: One of each script.
        gamma: The learner's discount per step, in (0, 1].
        names: What the two are called.
        setting: Where the scripted policies were recorded.

    Raises:
        SimulationDiverged: One of the two pays a number that is not finite.
        UsageError: One of the two reads what no step of an arm has, or its terms are none.
    """
    name, other = names
    scores, others = ([score_rollout(it, rollout) for rollout in rollouts] for it in (reward, against))
    needed = needed_beside_distances(reward, scores)
    because = tuple(dict.fromkeys((*needed, *needed_beside_distances(against, others))))
    forms_in = forms_of_rollouts if because else forms_of_distances
    forms = compare_forms(other, forms_in(against, rollouts, gamma), name, forms_in(reward, rollouts, gamma))
    finishing = finishing_of(scores, gamma)
    asked = OfScripts(
        finishing,
        properties_of(reward, [rollout.distances[:, :TRIED] for rollout in rollouts], gamma, needed),
        {rollout.script: None for rollout in rollouts} if needed else workspace_ratios(reward, rollouts),
        needed,
        because,
        min(COMPARED, finishing.steps) if because else finishing.steps,
    )
    both = [dict(zip((other, name), of, strict=True)) for of in zip(others, scores, strict=True)]
    paid = sum(map(_paid, both[1:]), _paid(both[0]))
    return Audit(
        title=name,
        setting=(setting,) if setting else (),
        facts={},
        rewards=tuple(both[0]),
        pairs=(
            pair_of(other, name, [compare_paid(paid, other, name)], list(map(_line, others, scores)), forms=[forms]),
        ),
        earned=tuple(
            earned_in_episodes(score.rollout.script, [_episodes(of)], list(of), (SUCCESS, STEPS))
            for score, of in zip(scores, both, strict=True)
        ),
        success=SUCCESS,
        verdict=tuple(verdict_of(asked)),
        scripts=asked,
        measured=(
            f"{SCALE} {asked.compared:,} recorded steps were compared.",
            *([RECORDED.format(", ".join(because))] if because else []),
        ),
    )


def _paid(scores: Mapping[str, Score]) -> Paid:
    """What both rewards paid in one rollout, the events left out, which the task pays under either."""
    steps = {name: score.values[score.rollout.running] for name, score in scores.items()}
    return Paid(steps, {name: score.values.sum(axis=0) for name, score in scores.items()}, {})


def _episodes(scores: Mapping[str, Score]) -> Episodes:
    """The episodes of one rollout, the events among what they were paid."""
    rollout = next(iter(scores.values())).rollout
    returns = {name: score.paid.sum(axis=0) for name, score in scores.items()}
    measures = {SUCCESS: np.asarray(rollout.reached, np.float64), STEPS: rollout.steps}
    return Episodes(np.cumsum(rollout.steps).astype(np.int64) - 1, returns, measures, {})


def _line(other: Score, score: Score) -> Line | None:
    """What a reward paid in the steps of a rollout, over what the other one paid; the event terms are the task's."""
    running = score.rollout.running
    can_end = bool(score.rollout.reached.any())
    return line_of(other.values[running], score.values[running], can_end=can_end)

"""Everything that is asked about a reward, answered."""

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any

from harness.audit.canonical import Coverage, anywhere, nearby
from harness.audit.distance import Distance, reward_distance
from harness.audit.payoff import Payoff, Temptation, holding_pays, never_paid, payoff_of, temptations
from harness.audit.probe import needed_beside_distances
from harness.audit.properties import Property, properties_of
from harness.audit.rollout import Rollout
from harness.audit.score import Score, score_rollout
from harness.audit.transitions.form_distances import DARD, EPIC, STARC
from harness.audit.transitions.rollout_distances import transition_distances
from harness.audit.workspace import workspace_ratios
from harness.eta.rescaling import Line, Rescaling, line_of, rescaling_of
from harness.reward import Reward

TRIED = 64
"""So many episodes of each script are enough to try properties on."""


@dataclass(frozen=True)
class Audit:
    """What a reward pays for.

    Attributes:
        gamma: Discount of the discounted figures.
        payoffs: One of each scripted policy, the best return first.
        undiscounted: What pays more than finishing, without discount.
        discounted: The same with it.
        holding_pays: Whether standing still at the start does.
        steps: How many steps the policies took in all.
        never_paid: The terms that paid nothing in any of them.
        properties: Bounded, scale-free, potential-based.
        workspace: Of each policy, by what its shaped return grows when all distances double.
        distance: To the reward it was compared with: EPIC.
        reachable_distance: The same, in steps that the arm can do: DARD.
        starc_distance: STARC, where one of the two reads more than distances; else None.
        needed: The fields beside distances that the reward needs.
        recorded_because: The same of either reward: because of them the distances rest on recorded transitions.
        rescaling: What the reward is, if it is the one that it was compared with but for scale and offset; else None.
    """

    gamma: float
    payoffs: tuple[Payoff, ...]
    undiscounted: tuple[Temptation, ...]
    discounted: tuple[Temptation, ...]
    holding_pays: bool
    steps: int
    never_paid: tuple[str, ...]
    properties: tuple[Property, ...]
    workspace: dict[str, float | None]
    distance: Distance
    reachable_distance: Distance
    starc_distance: Distance | None
    needed: tuple[str, ...]
    recorded_because: tuple[str, ...]
    rescaling: Rescaling | None

    def to_json(self) -> dict[str, Any]:
        """Plain data, finite numbers only. What a reward of distances without terms has not is left out."""
        more = {
            "never_paid": list(self.never_paid) if self.payoffs[0].terms else None,
            "starc_distance": self.starc_distance and self.starc_distance.to_json(),
            "recorded_transitions_because_of": list(self.recorded_because) or None,
        }
        return {
            "gamma": self.gamma,
            "policies": [payoff.to_json() for payoff in self.payoffs],
            "best": self.payoffs[0].policy,
            "not_finishing_pays": [
                {**asdict(temptation), "margin": temptation.margin}
                for temptation in (*self.undiscounted, *self.discounted)
            ],
            "holding_pays": self.holding_pays,
            "properties": {
                answer.name.replace("-", "_"): {
                    "holds": answer.holds,
                    "evidence": answer.evidence,
                    "gamma": answer.gamma,
                }
                for answer in self.properties
            },
            "workspace_twice_as_large": self.workspace,
            "distance": self.distance.to_json(),
            "reachable_distance": self.reachable_distance.to_json(),
            "rescaled": self.rescaling and self.rescaling.to_json(),
            **{name: value for name, value in more.items() if value is not None},
        }


def audit_reward(reward: Reward, against: Reward, rollouts: Sequence[Rollout], gamma: float) -> Audit:
    """What `reward` pays for in the rollouts of the scripted policies.

    Args:
        reward: The reward.
        against: The one that it is compared with.
        rollouts: One of each script.
        gamma: The learner's discount per step, in (0, 1].

    Raises:
        SimulationDiverged: One of the two pays a number that is not finite.
        UsageError: One of the two reads what no step of an arm has, or its terms are none.
    """
    scores = [score_rollout(reward, rollout) for rollout in rollouts]
    others = [score_rollout(against, rollout) for rollout in rollouts]
    payoffs = [payoff_of(score, gamma) for score in scores]
    needed, of_other = needed_beside_distances(reward, scores), needed_beside_distances(against, others)
    because = tuple(dict.fromkeys((*needed, *of_other)))
    distances = distances_of(reward, against, rollouts, gamma, recorded=bool(because))
    return Audit(
        gamma,
        tuple(sorted(payoffs, key=lambda payoff: -payoff.total)),
        tuple(temptations(scores, 1.0)),
        tuple(temptations(scores, gamma)),
        holding_pays(payoffs),
        sum(int(rollout.running.sum()) for rollout in rollouts),
        never_paid(scores),
        properties_of(reward, [rollout.distances[:, :TRIED] for rollout in rollouts], gamma, needed),
        {rollout.script: None for rollout in rollouts} if needed else workspace_ratios(reward, rollouts),
        distances[EPIC],
        distances[DARD],
        distances.get(STARC),
        needed,
        because,
        rescaling_of([_line(*of) for of in zip(others, scores, strict=True)]),
    )


def distances_of(
    reward: Reward, against: Reward, rollouts: Sequence[Rollout], gamma: float, *, recorded: bool
) -> dict[str, Distance]:
    """How far apart two rewards are, by canonical form.

    Args:
        reward: A reward.
        against: Another one; the order does not count.
        rollouts: One of each script.
        gamma: Discount per step.
        recorded: Whether to ask about recorded transitions, or else about made-up distances.
    """
    if recorded:
        return transition_distances(reward, against, rollouts, gamma)
    coverages: dict[str, Coverage] = {EPIC: anywhere, DARD: nearby}
    return {form: reward_distance(reward, against, rollouts, gamma, of) for form, of in coverages.items()}


def _line(other: Score, score: Score) -> Line | None:
    """What a reward paid in the steps of a rollout, over what the other one paid; the event terms are the task's."""
    running = score.rollout.running
    can_end = bool(score.rollout.reached.any())
    return line_of(other.values[running], score.values[running], can_end=can_end)

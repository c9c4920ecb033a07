"""Everything that is asked about a reward, answered."""

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any

from harness.audit.canonical import anywhere, nearby
from harness.audit.distance import Distance, reward_distance
from harness.audit.payoff import Payoff, Temptation, holding_pays, payoff_of, temptations
from harness.audit.properties import Property, properties_of
from harness.audit.rollout import Rollout
from harness.audit.score import Score, score_rollout
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
        properties: Bounded, scale-free, potential-based.
        workspace: Of each policy, by what its shaped return grows when all distances double.
        distance: To the reward it was compared with: EPIC.
        reachable_distance: The same, in steps that the arm can do: DARD.
        rescaling: What the reward is, if it is the one that it was compared with but for scale and offset; else None.
    """

    gamma: float
    payoffs: tuple[Payoff, ...]
    undiscounted: tuple[Temptation, ...]
    discounted: tuple[Temptation, ...]
    holding_pays: bool
    properties: tuple[Property, ...]
    workspace: dict[str, float | None]
    distance: Distance
    reachable_distance: Distance
    rescaling: Rescaling | None

    def to_json(self) -> dict[str, Any]:
        """Plain data, finite numbers only."""
        return {
            "gamma": self.gamma,
            "policies": [asdict(payoff) for payoff in self.payoffs],
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
            "distance": asdict(self.distance),
            "reachable_distance": asdict(self.reachable_distance),
            "rescaled": self.rescaling and self.rescaling.to_json(),
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
    """
    scores = [score_rollout(reward, rollout) for rollout in rollouts]
    others = [score_rollout(against, rollout) for rollout in rollouts]
    payoffs = [payoff_of(score, gamma) for score in scores]
    epic, dard = (reward_distance(reward, against, rollouts, gamma, coverage) for coverage in (anywhere, nearby))
    return Audit(
        gamma,
        tuple(sorted(payoffs, key=lambda payoff: -payoff.total)),
        tuple(temptations(scores, 1.0)),
        tuple(temptations(scores, gamma)),
        holding_pays(payoffs),
        properties_of(reward, [rollout.distances[:, :TRIED] for rollout in rollouts], gamma),
        workspace_ratios(reward, rollouts),
        epic,
        dard,
        rescaling_of([_line(*of) for of in zip(others, scores, strict=True)]),
    )


def _line(other: Score, score: Score) -> Line | None:
    """What a reward paid in the steps of a rollout, over what the other one paid; the event terms are the task's."""
    running = score.rollout.running
    can_end = bool(score.rollout.reached.any())
    return line_of(other.values[running], score.values[running], can_end=can_end)

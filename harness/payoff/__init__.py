"""What rewards pay what is there already: scripted movements of an arm, and the steps of data sets."""

from typing import TYPE_CHECKING, Any

from harness.face import look_up

if TYPE_CHECKING:
    from harness.payoff.dataset.arm_pay import of_arm
    from harness.payoff.dataset.paid_dataset import pay_dataset
    from harness.payoff.dataset.scores_file import write_dataset_scores
    from harness.payoff.dataset.step_by_step import step_by_step
    from harness.payoff.finishing import finishing_of, never_paid, payoff_of, temptations
    from harness.payoff.rollout import SCRIPTS, Rollout, plan_actions, record_rollouts
    from harness.payoff.score import discounted_sum, pay_distances, score_rollout, steps_along

__all__ = [
    "SCRIPTS",
    "Rollout",
    "discounted_sum",
    "finishing_of",
    "never_paid",
    "of_arm",
    "pay_dataset",
    "pay_distances",
    "payoff_of",
    "plan_actions",
    "record_rollouts",
    "score_rollout",
    "step_by_step",
    "steps_along",
    "temptations",
    "write_dataset_scores",
]

_HOMES = {
    "dataset.arm_pay": "of_arm",
    "dataset.paid_dataset": "pay_dataset",
    "dataset.scores_file": "write_dataset_scores",
    "dataset.step_by_step": "step_by_step",
    "finishing": "finishing_of never_paid payoff_of temptations",
    "rollout": "SCRIPTS Rollout plan_actions record_rollouts",
    "score": "discounted_sum pay_distances score_rollout steps_along",
}


def __getattr__(name: str) -> Any:
    return look_up(__name__, _HOMES, name)

"""What rewards pay what is there already: scripted movements of an arm, and the steps of data sets."""

from typing import TYPE_CHECKING

from harness.face import face_of

if TYPE_CHECKING:
    from harness.payoff.dataset.arm_pay import of_arm as of_arm
    from harness.payoff.dataset.paid_dataset import pay_dataset as pay_dataset
    from harness.payoff.dataset.scores_file import write_dataset_scores as write_dataset_scores
    from harness.payoff.dataset.step_by_step import step_by_step as step_by_step
    from harness.payoff.rollout import (
        SCRIPTS as SCRIPTS,
        Rollout as Rollout,
        discounted_sum as discounted_sum,
        finishing_of as finishing_of,
        pay_distances as pay_distances,
        payoff_of as payoff_of,
        plan_actions as plan_actions,
        record_rollouts as record_rollouts,
        score_rollout as score_rollout,
        steps_along as steps_along,
        temptations as temptations,
    )
else:
    __all__, __getattr__ = face_of(__name__, __file__)

"""Recorded runs, paid again under other rewards."""

from typing import TYPE_CHECKING

from harness.face import face_of

if TYPE_CHECKING:
    from harness.score.compare import (
        compare_logs as compare_logs,
        guess_reward as guess_reward,
    )
    from harness.score.csv_steps import EVENTS as EVENTS, StepsCsv as StepsCsv
    from harness.score.installed_reward import InstalledReward as InstalledReward
    from harness.score.open_steps import match_steps as match_steps
    from harness.score.places import (
        ArmPay as ArmPay,
        parse_place as parse_place,
        parse_places as parse_places,
    )
    from harness.score.scorer import Payer as Payer, Scorer as Scorer, can_be_paid as can_be_paid, pay_log as pay_log
    from harness.score.weighted_recordings import (
        pay_by_weights as pay_by_weights,
        recorded_weights as recorded_weights,
        recordings_of as recordings_of,
    )
    from harness.score.weights import (
        label_by_terms as label_by_terms,
        recorded_choice as recorded_choice,
        reweighted as reweighted,
    )
else:
    __all__, __getattr__ = face_of(__name__, __file__)

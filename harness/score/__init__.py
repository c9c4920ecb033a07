"""Recorded runs, paid again under other rewards."""

from typing import TYPE_CHECKING, Any

from harness.face import look_up

if TYPE_CHECKING:
    from harness.score.compare import ComparedRuns, compare_logs, guess_reward
    from harness.score.csv_steps import EVENTS, StepsCsv
    from harness.score.installed_reward import InstalledReward
    from harness.score.open_steps import match_steps
    from harness.score.places import ArmPay, Place, distances, parse_place, parse_places
    from harness.score.scorer import Payer, Scorer, can_be_paid, pay_log
    from harness.score.weighted_recordings import pay_by_weights, recorded_weights, recordings_of
    from harness.score.weights import recorded_choice, reweighted, weighted_label

__all__ = [
    "EVENTS",
    "ArmPay",
    "ComparedRuns",
    "InstalledReward",
    "Payer",
    "Place",
    "Scorer",
    "StepsCsv",
    "can_be_paid",
    "compare_logs",
    "distances",
    "guess_reward",
    "match_steps",
    "parse_place",
    "parse_places",
    "pay_by_weights",
    "pay_log",
    "recorded_choice",
    "recorded_weights",
    "recordings_of",
    "reweighted",
    "weighted_label",
]

_HOMES = {
    "compare": "ComparedRuns compare_logs guess_reward",
    "csv_steps": "EVENTS StepsCsv",
    "installed_reward": "InstalledReward",
    "open_steps": "match_steps",
    "places": "ArmPay Place distances parse_place parse_places",
    "scorer": "Payer Scorer can_be_paid pay_log",
    "weighted_recordings": "pay_by_weights recorded_weights recordings_of",
    "weights": "recorded_choice reweighted weighted_label",
}


def __getattr__(name: str) -> Any:
    return look_up(__name__, _HOMES, name)

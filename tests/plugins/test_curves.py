"""The table of names under which programs log their curves."""

from pathlib import Path

import pytest

from harness.errors import UsageError
from harness_plugins.curves import CURVES, CurveSettings, is_history, is_known

PATH = Path("log")


def test_no_two_programs_have_one_name():
    """A name says whose it is."""
    names = [curve.reward for curve in CURVES]
    assert len(set(names)) == len(names)


def test_every_curve_is_chosen_by_its_own_names(subtests):
    """With its success and its length where they are there."""
    for curve in CURVES:
        with subtests.test(curve=curve):
            names = [curve.reward, *curve.success[:1], *([curve.length] if curve.length else [])]
            chosen = CurveSettings().chosen(PATH, names)
            assert is_known(names)
            assert (chosen.program, chosen.reward) == (curve.program, curve.reward)
            assert chosen.success == curve.success[:1]
            assert chosen.length == curve.length


def test_training_goes_before_evaluation_and_success_before_both():
    """Success decides."""
    both = ["eval/mean_reward", "rollout/ep_rew_mean"]
    assert CurveSettings().chosen(PATH, both).reward == "rollout/ep_rew_mean"
    assert CurveSettings().chosen(PATH, [*both, "eval/success_rate"]).reward == "eval/mean_reward"


def test_what_a_user_names_goes_before_all():
    """A measure and a length too."""
    names = ["rollout/ep_rew_mean", "mine", "error", "steps"]
    chosen = CurveSettings(reward="mine", measure="error", length="steps").chosen(PATH, names)
    assert chosen.columns == {"reward/recorded": "mine", "length": "steps", "behaviour/error": "error"}


def test_a_log_without_a_known_curve_is_told_what_to_say():
    """And what it has."""
    with pytest.raises(UsageError, match=r"say reward=NAME\. It has: loss"):
        CurveSettings().chosen(PATH, ["loss"])


def test_a_history_of_weights_and_biases_is_known_by_its_own_columns():
    """Whatever else logged into it."""
    assert is_history(["_step", "_timestamp", "rollout/ep_rew_mean"])
    assert not is_history(["rollout/ep_rew_mean"])

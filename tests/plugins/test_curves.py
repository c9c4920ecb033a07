"""The table of names under which programs log their curves."""

from pathlib import Path

import numpy as np
import pytest

from harness.errors import UsageError
from harness.log import LogFacts
from harness_plugins.curves import CURVES, CurveSettings, curve_log, is_history, is_known

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


@pytest.mark.parametrize(
    ("names", "settings", "since"),
    [
        (["rollout/ep_rew_mean", "rollout/ep_len_mean"], {}, [0, 0, 900]),
        (["rollout/ep_rew_mean"], {}, [np.nan] * 3),
        (["rollout/ep_rew_mean"], {"episode": 10}, [0, 500, 1500]),
        (["eval/mean_reward"], {}, [500, 1500, 2500]),
        (["Environment/Cumulative Reward"], {}, [0, 500, 1500]),
        (["charts/episodic_return", "charts/episodic_length"], {}, [484, 1484, 2484]),
        (["charts/episodic_return"], {}, [0, 500, 1500]),
        (["episode_reward_mean", "episode_len_mean"], {}, [0, 0, 900]),
        (["mine"], {"reward": "mine"}, [np.nan] * 3),
    ],
)
def test_a_point_tells_from_where_on_it_averages(names, settings, since):
    """A mean over the last 100 episodes spans a hundred lengths; an evaluation spans no steps; else nobody knows."""
    told, steps = CurveSettings(**settings), np.array([500.0, 1500.0, 2500.0])
    columns = {
        **dict.fromkeys(["global_step", "timesteps_total", "step"], steps),
        **dict.fromkeys(names, np.full(3, 16.0)),
    }
    log = curve_log(LogFacts(path=PATH, format="it"), told.chosen(PATH, names), names, columns, told)
    np.testing.assert_array_equal(log["since"], since)

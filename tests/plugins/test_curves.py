"""The dictionary of names under which programs log, and what their points are."""

from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_array_equal

from harness.log import LogFacts
from harness_plugins.curves import Roles, points
from tests.refusals import refused

PATH = Path("log")
SB3 = ("rollout/ep_rew_mean", "rollout/success_rate", "rollout/ep_len_mean")
EVALUATED = ("eval/mean_reward", "eval/success_rate", "eval/mean_ep_length")
RLLIB = ("env_runners/episode_return_mean", "custom_metrics/success_rate_mean", "env_runners/episode_len_mean")


@pytest.mark.parametrize(
    "names",
    [
        SB3,
        EVALUATED,
        RLLIB,
        tuple(f"ray/tune/evaluation/{name}" for name in RLLIB),
        ("episode_reward_mean", "custom_metrics/success_mean", "episode_len_mean"),
        ("charts/episodic_return", "charts/success", "charts/episodic_length"),
        ("Training/Episode Return", "Training/Success Rate", ""),
        ("Environment/Cumulative Reward", "", "Environment/Episode Length"),
        ("Train/mean_reward", "Metrics/success_rate", "Train/mean_episode_length"),
        ("rewards/step", "", "episode_lengths/step"),
        ("Reward / Total reward (mean)", "", "Episode / Total timesteps (mean)"),
        ("AverageTestEpRet", "", "TestEpLen"),
        ("EpRewMean", "", "EpLenMean"),
        ("Evaluation/AverageReturn", "Evaluation/SuccessRate", ""),
        ("episode/score", "", "episode/length"),
        ("train/returns_stat/mean", "", "train/lens_stat/mean"),
    ],
)
def test_the_names_of_a_program_are_known(names):
    """Its returns, its success, its lengths; whatever else it logs is none of them."""
    others = ["loss/value", "time/fps", "train/learning_rate", "rewards/iter", "charts/SPS"]
    chosen = Roles().chosen(PATH, [*others, *filter(None, names)])
    told = {role: name for role, name in zip(("reward", "success", "length"), names, strict=True) if name}
    assert chosen.columns == told
    assert chosen.evaluation == any(word in names[0].lower() for word in ("eval", "test"))


def test_training_goes_before_evaluation_and_success_before_both():
    """Success decides; what else is there is told."""
    assert Roles().chosen(PATH, [EVALUATED[0], SB3[0]]).columns == {"reward": SB3[0]}
    chosen = Roles().chosen(PATH, [EVALUATED[0], SB3[0], EVALUATED[1]])
    assert (chosen.columns["reward"], chosen.others) == (EVALUATED[0], (SB3[0],))


def test_what_a_user_names_goes_before_all():
    """A measure and a length too."""
    names = ["rollout/ep_rew_mean", "mine", "error", "long"]
    chosen = Roles(reward="mine", measure="error", length="long").chosen(PATH, names)
    assert chosen.columns == {"reward": "mine", "length": "long", "measure": "error"}


def test_a_log_without_a_known_curve_is_told_what_to_say():
    """And what it has."""
    with refused(r"say reward=NAME\. It has: loss"):
        Roles().chosen(PATH, ["loss"])


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
    told, steps = Roles(**settings), np.array([500.0, 1500.0, 2500.0])
    columns = {"timesteps_total": steps, "step": steps, **dict.fromkeys(names, np.full(3, 16.0))}
    chosen = told.chosen(PATH, [*names, "timesteps_total"])
    assert_array_equal(points(LogFacts(path=PATH, format="it"), chosen, columns, told)["since"], since)

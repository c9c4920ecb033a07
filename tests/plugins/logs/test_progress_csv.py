"""Tables of progress that stable-baselines3's own logger writes, and what happens to such tables."""

import pytest

from tests.plugins.logs.reading import Reader

REWARD, STEPS = "rollout/ep_rew_mean", "time/total_timesteps"

read = Reader("table", "progress.csv")


def logged(folder, reports):
    """What stable-baselines3's own logger wrote of reports."""
    logger = pytest.importorskip("stable_baselines3.common.logger", reason="needs the extra sb3")
    writer = logger.CSVOutputFormat(str(folder / "progress.csv"))
    for report in reports:
        writer.write(dict(report), dict.fromkeys(report, ()))
    writer.close()
    return folder / "progress.csv"


def test_keys_that_come_later_stand_under_their_names(tmp_path):
    """Issue 774 of baselines: a table whose header grows on the way. The library pads the rows before."""
    reports = [
        {STEPS: 100, REWARD: -9.5},
        {"aaa/new": 1.0, STEPS: 200, REWARD: -8.25},
        {STEPS: 300, "rollout/success_rate": 0.5, REWARD: -7.125, "aaa/new": 2.0},
        {REWARD: -6.0625, STEPS: 400, "rollout/success_rate": 0.75},
    ]
    log = read(logged(tmp_path, reports))
    assert log["time"].tolist() == [300, 400]
    assert log["reward/recorded"].tolist() == [-7.125, -6.0625]
    assert log["behaviour/success"].tolist() == [0.5, 0.75]
    assert any("2 points that lack one of these are left out" in note for note in log.facts.notes)


def test_evaluations_in_rows_of_their_own_are_read_where_they_have_success(tmp_path):
    """EvalCallback dumps rows of its own into the same table."""
    reports = [
        {STEPS: 100, REWARD: -9.5},
        {STEPS: 150, "eval/mean_reward": -8.0, "eval/success_rate": 0.25, "eval/mean_ep_length": 20.0},
        {STEPS: 200, REWARD: -7.5},
    ]
    log = read(logged(tmp_path, reports))
    assert log["time"].tolist() == [150]
    assert log.facts.evaluation
    assert read(tmp_path / "progress.csv", reward=REWARD)["time"].tolist() == [100, 200]
